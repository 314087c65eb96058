//! Load balancers.

/// Share `index` of `0..items` divided evenly into `count` shares.
pub fn even_share(items: usize, index: usize, count: usize) -> std::ops::Range<usize> {
    let (each, extra) = (items / count, items % count);
    let start = index * each + index.min(extra);
    start..start + each + usize::from(index < extra)
}
