//! The rows of `mobula kernels` with criterion's statistics and baselines:
//! `cargo bench -p mobula-benches --bench kernels -- --save-baseline main 'triangle/.*/avx2'`.
//! Each case is checked before it is timed.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use mobula_core::lab::{Dice, WIDTHS};
use mobula_core::simd::AnyToken;

fn kernels(criterion: &mut Criterion) {
    for kernel in mobula_benches::kernels() {
        let mut group = criterion.benchmark_group(format!("{}/{}", kernel.kernel, kernel.case));
        for token in AnyToken::available() {
            for &width in WIDTHS {
                kernel.check(token, width, &mut Dice::from_seed(1)).unwrap_or_else(|wrong| panic!("{wrong}"));
                let mut pass = kernel.prepare(token, width);
                group.throughput(Throughput::Elements(pass(1) as u64));
                group.bench_function(BenchmarkId::new(token.level().name(), width), |bencher| bencher.iter(|| pass(1)));
            }
        }
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(std::time::Duration::from_millis(100))
        .measurement_time(std::time::Duration::from_millis(400));
    targets = kernels
}
criterion_main!(benches);
