//! `y += k * x`, written once and run at every level of this machine: `cargo run -p mobula-simd --example saxpy`.

use mobula_simd::{AnyToken, F32Lanes, Task, Token};

struct Saxpy<'a> {
    k: f32,
    x: &'a [f32],
    y: &'a mut [f32],
}

impl Task for Saxpy<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let k = token.splat(self.k);
        // No loop for the remainder: lanes beyond the end read as zero and are not written.
        for at in (0..self.x.len()).step_by(T::LANES) {
            k.mul_add(token.load(self.x, at), token.load(self.y, at)).store(self.y, at);
        }
    }
}

fn main() {
    let x: Vec<f32> = (0..1001).map(|i| i as f32).collect();
    for token in AnyToken::available() {
        let mut y = vec![1.0; x.len()];
        token.run(Saxpy { k: 0.5, x: &x, y: &mut y });
        assert!(x.iter().zip(&y).all(|(x, y)| *y == 0.5 * x + 1.0));
        println!("{:8} y[1000] = {}", token.level(), y[1000]);
    }
}
