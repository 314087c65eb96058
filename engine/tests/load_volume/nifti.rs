//! NIfTI: both versions and byte orders, types, places, slopes, time.

use glam::DVec3;

use super::{Folder, gzip, samples, values};

/// A header that is made field by field.
#[derive(Clone)]
pub(crate) struct Nifti {
    two: bool,
    big: bool,
    bytes: Vec<u8>,
}

impl Nifti {
    /// A header with voxels of a type by number.
    pub(crate) fn new(two: bool, big: bool, sizes: &[i64], datatype: i64) -> Self {
        let bytes = vec![0; if two { 544 } else { 352 }];
        let mut header = Self { two, big, bytes };
        header.int(0, 4, if two { 540 } else { 348 });
        header.mark(if two { b"n+2\0\r\n\x1a\n" } else { b"n+1\0" });
        header.dim(0, sizes.len() as i64);
        (1..8).for_each(|i| header.dim(i, sizes.get(i - 1).copied().unwrap_or(1)));
        header.int(if two { 12 } else { 70 }, 2, datatype);
        (1..4).for_each(|i| header.pixdim(i, 1.0));
        header.offset(header.bytes.len() as f64);
        header
    }

    fn int(&mut self, at: usize, size: usize, value: i64) {
        let bytes = if self.big { value.to_be_bytes() } else { value.to_le_bytes() };
        let part = if self.big { &bytes[8 - size..] } else { &bytes[..size] };
        self.bytes[at..at + size].copy_from_slice(part);
    }

    /// A float where version 1 has it, and a double where version 2 does.
    fn float(&mut self, [one, two]: [usize; 2], i: usize, value: f64) {
        if self.two {
            let bytes = if self.big { value.to_be_bytes() } else { value.to_le_bytes() };
            self.bytes[two + 8 * i..][..8].copy_from_slice(&bytes);
        } else {
            let value = value as f32;
            let bytes = if self.big { value.to_be_bytes() } else { value.to_le_bytes() };
            self.bytes[one + 4 * i..][..4].copy_from_slice(&bytes);
        }
    }

    fn mark(&mut self, mark: &[u8]) {
        let at = if self.two { 4 } else { 344 };
        self.bytes[at..at + mark.len()].copy_from_slice(mark);
    }

    fn dim(&mut self, i: usize, value: i64) {
        if self.two { self.int(16 + 8 * i, 8, value) } else { self.int(40 + 2 * i, 2, value) }
    }

    fn pixdim(&mut self, i: usize, value: f64) {
        self.float([76, 104], i, value);
    }

    fn offset(&mut self, value: f64) {
        if self.two { self.int(168, 8, value as i64) } else { self.float([108, 0], 0, value) }
    }

    fn slope(&mut self, slope: f64, intercept: f64) {
        self.float([112, 176], 0, slope);
        self.float([116, 184], 0, intercept);
    }

    fn sform(&mut self, code: i64, rows: [[f64; 4]; 3]) {
        if self.two {
            self.int(348, 4, code)
        } else {
            self.int(254, 2, code)
        }
        for (k, row) in rows.iter().enumerate() {
            (0..4).for_each(|i| self.float([280, 400], 4 * k + i, row[i]));
        }
    }

    fn qform(&mut self, code: i64, numbers: [f64; 6]) {
        if self.two {
            self.int(344, 4, code)
        } else {
            self.int(252, 2, code)
        }
        (0..6).for_each(|i| self.float([256, 352], i, numbers[i]));
    }

    fn with(&self, voxels: &[u8]) -> Vec<u8> {
        [&self.bytes[..], voxels].concat()
    }
}

/// A file with 8 x 6 x 5 bytes.
pub(crate) fn sample(voxels: &[u8]) -> Vec<u8> {
    Nifti::new(false, false, &[8, 6, 5], 2).with(voxels)
}

/// A small file whose every field says something.
pub(crate) fn small() -> Vec<u8> {
    let mut header = Nifti::new(false, true, &[2, 3, 2], 2);
    header.sform(1, [[1.0, 0.0, 0.0, 5.0], [0.0, 2.0, 0.0, 6.0], [0.0, 0.0, 3.0, 7.0]]);
    header.slope(2.0, -1.0);
    header.with(&[3; 12])
}

/// Both versions in both byte orders.
const KINDS: [(bool, bool); 4] = [(false, false), (false, true), (true, false), (true, true)];

#[test]
fn every_type_version_and_order() {
    let folder = Folder::new("nifti-types");
    for (sample, datatype) in samples().iter().zip([2, 256, 512, 4, 768, 8, 16, 64]) {
        for (two, big) in KINDS {
            let bytes = if big { &sample.big } else { &sample.little };
            let file = Nifti::new(two, big, &[2, 3, 4], datatype).with(bytes);
            for (name, file) in [("a.nii", file.clone()), ("a.nii.gz", gzip(&file)), ("unnamed", file)] {
                let loaded = folder.load(name, file).unwrap();
                let grid = &super::only_volume(&loaded).steps[0];
                assert_eq!(grid.dims(), [2, 3, 4]);
                assert_eq!((grid.voxels().type_name(), values(grid)), (sample.name, sample.values.clone()));
                assert_eq!(grid.scale(), [1.0, 0.0]);
                assert!(loaded.report.format.starts_with(if two { "NIfTI-2" } else { "NIfTI-1" }));
            }
        }
    }
}

#[test]
fn places_slopes_and_time() {
    let folder = Folder::new("nifti-places");
    let bytes: Vec<u8> = (0..12).collect();
    for (two, big) in KINDS {
        let plain = {
            let mut header = Nifti::new(two, big, &[2, 3, 2], 2);
            [0.5, 2.0, 4.0].into_iter().enumerate().for_each(|(i, x)| header.pixdim(i + 1, x));
            header
        };
        let place = |header: &Nifti| *folder.grid("a.nii", header.with(&bytes)).place();
        assert_eq!(place(&plain).axes, [DVec3::X * 0.5, DVec3::Y * 2.0, DVec3::Z * 4.0]);

        // A quarter of a turn around z, and the third axis turned around.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let mut turned = plain.clone();
        turned.qform(1, [0.0, 0.0, half, 5.0, 6.0, 7.0]);
        let found = place(&turned);
        assert_eq!(found.origin, DVec3::new(5.0, 6.0, 7.0));
        let near = |found: [DVec3; 3], expected: [DVec3; 3]| (0..3).all(|k| (found[k] - expected[k]).length() < 1e-6);
        assert!(near(found.axes, [DVec3::Y * 0.5, DVec3::X * -2.0, DVec3::Z * 4.0]), "{found:?}");
        turned.pixdim(0, -1.0);
        assert!(near(place(&turned).axes, [DVec3::Y * 0.5, DVec3::X * -2.0, DVec3::Z * -4.0]));

        // A matrix counts before a rotation.
        turned.sform(2, [[0.0, 3.0, 0.0, -1.0], [2.0, 0.0, 0.0, -2.0], [0.0, 0.0, -1.0, -3.0]]);
        let found = place(&turned);
        assert_eq!(
            (found.origin, found.axes),
            (DVec3::new(-1.0, -2.0, -3.0), [DVec3::Y * 2.0, DVec3::X * 3.0, -DVec3::Z])
        );

        for (slope, intercept, expected) in [(2.0, -1.5, [2.0, -1.5]), (0.0, 7.0, [1.0, 0.0]), (-1.0, 0.0, [-1.0, 0.0])]
        {
            let mut header = plain.clone();
            header.slope(slope, intercept);
            let grid = folder.grid("a.nii", header.with(&bytes));
            assert_eq!(grid.scale(), expected);
            let [a, b] = [0.0, 11.0].map(|x| x * expected[0] + expected[1]);
            assert_eq!(grid.range(), Some([f64::min(a, b), f64::max(a, b)]));
        }

        let mut steps = Nifti::new(two, big, &[2, 1, 3, 2], 2);
        steps.offset(600.0);
        let padded = [&vec![0xee; 600 - steps.bytes.len()][..], &bytes].concat();
        let volume = folder.volume("a.nii", steps.with(&padded));
        assert_eq!(
            volume.steps.iter().map(|step| values(step)).collect::<Vec<_>>(),
            [[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [6.0, 7.0, 8.0, 9.0, 10.0, 11.0]]
        );
        let five = Nifti::new(two, big, &[2, 3, 2, 1, 1, 1, 1], 2);
        assert_eq!(folder.grid("a.nii", five.with(&bytes)).dims(), [2, 3, 2]);
    }
}

#[test]
fn broken_headers() {
    let folder = Folder::new("nifti-broken");
    let bytes = [1; 12];
    for (two, big) in KINDS {
        let sized = |sizes: &[i64]| Nifti::new(two, big, sizes, 2);
        let changed = |change: &dyn Fn(&mut Nifti)| {
            let mut header = Nifti::new(two, big, &[2, 3, 2], 2);
            change(&mut header);
            header
        };
        let typed = |datatype| Nifti::new(two, big, &[2, 3, 2], datatype);
        let flat = [[1.0, 2.0, 3.0, 0.0], [2.0, 4.0, 6.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let mut nan = flat;
        nan[1][3] = f64::NAN;
        for (header, expected) in [
            (sized(&[4, 3]), "it has 2 dimensions: a volume has three"),
            (changed(&|header| header.dim(0, 0)), "it has 0 dimensions, not 1 to 7"),
            (changed(&|header| header.dim(0, 9)), "it has 9 dimensions, not 1 to 7"),
            (sized(&[2, 0, 2]), "a grid of 2 x 0 x 2 has no samples"),
            (sized(&[2, -3, 2]), "a dimension has -3 samples"),
            (sized(&[2, 3, 2, 0]), "in 0 steps has no samples"),
            (sized(&[2, 3, 2, 1, 3]), "more than four dimensions are not supported"),
            (sized(&[32_767, 32_767, 32_767, 32_767]), "bytes of voxels missing"),
            (typed(1), "voxels that are single bits are not supported"),
            (typed(128), "voxels that are colours are not supported"),
            (typed(32), "voxels that are complex numbers are not supported"),
            (typed(1024), "voxels that are integers of 64 bits are not supported"),
            (typed(99), "voxels of type 99 are not known"),
            (changed(&|header| header.slope(f64::NAN, 0.0)), "its voxels are to be scaled by NaN and 0"),
            (changed(&|header| header.slope(1.0, f64::INFINITY)), "its voxels are to be scaled by 1 and inf"),
            (changed(&|header| header.pixdim(2, 0.0)), "the spacing 1 x 0 x 1 is not above 0"),
            (changed(&|header| header.pixdim(2, f64::NAN)), "the spacing 1 x NaN x 1 is not above 0"),
            (changed(&|header| header.sform(1, flat)), "the directions of the grid are all in a plane"),
            (changed(&|header| header.sform(1, nan)), "the origin of the grid is not finite"),
            (changed(&|header| header.qform(1, [2.0, 0.0, 0.0, 0.0, 0.0, 0.0])), "its rotation is no unit quaternion"),
            (changed(&|header| header.qform(1, [f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0])), "no unit quaternion"),
            (changed(&|header| header.offset(12.0)), "its voxels start at byte 12, which is not behind the header"),
            (changed(&|header| header.offset(-1.0)), "its voxels start at byte -1"),
            (changed(&|header| header.offset(1e6)), "bytes before the voxels are to be skipped, but it has fewer"),
            (
                changed(&|header| header.mark(if two { b"ni2\0" } else { b"ni1\0" })),
                "voxels are in a file of their own",
            ),
            (changed(&|header| header.mark(b"xx")), if two { "not a NIfTI file" } else { "an Analyze file" }),
        ] {
            let complaint = folder.complaint("a.nii", header.with(&bytes));
            assert!(complaint.starts_with("a.nii: ") && complaint.contains(expected), "{expected}: {complaint}");
        }
    }
    let mut header = Nifti::new(false, false, &[2, 3, 2], 2);
    header.offset(f64::NAN);
    assert!(folder.complaint("a.nii", header.with(&bytes)).contains("its voxels start at byte NaN"));
    assert!(folder.complaint("a.nii", b"hello").contains("not a NIfTI file"));
    assert!(folder.complaint("a.nii", b"").contains("not a NIfTI file"));
    assert!(folder.complaint("a.nii", &header.bytes[..100]).contains("its header has 100 bytes instead of 348"));
    let header = Nifti::new(false, false, &[2, 3, 2], 2);
    assert_eq!(folder.warning("a.nii", header.with(&[1; 13])), "a.nii: 1 byte behind the voxels left out");
}
