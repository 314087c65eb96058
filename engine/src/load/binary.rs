//! Numbers out of bytes, and as many bytes as are wanted.

use std::io::{self, BufRead, ErrorKind};

use super::volume::VoxelType;

/// The number that the first bytes are; zero if there are too few.
#[inline]
pub(super) fn decode(kind: VoxelType, big_endian: bool, bytes: &[u8]) -> f64 {
    macro_rules! number {
        ($type:ty) => {{
            let bytes = bytes.first_chunk().copied().unwrap_or_default();
            f64::from(if big_endian { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) })
        }};
    }
    match kind {
        VoxelType::U8 => number!(u8),
        VoxelType::I8 => number!(i8),
        VoxelType::U16 => number!(u16),
        VoxelType::I16 => number!(i16),
        VoxelType::U32 => number!(u32),
        VoxelType::I32 => number!(i32),
        VoxelType::F32 => number!(f32),
        VoxelType::F64 => number!(f64),
    }
}

/// Fills `bytes` as far as there are any; returns how many that were.
#[inline]
pub(super) fn fill(reader: &mut dyn BufRead, bytes: &mut [u8]) -> io::Result<usize> {
    let mut count = 0;
    while count < bytes.len() {
        match reader.read(&mut bytes[count..]) {
            Ok(0) => break,
            Ok(more) => count += more,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_either_order() {
        for (kind, bytes, little, big) in [
            (VoxelType::U8, &[200][..], 200.0, 200.0),
            (VoxelType::I8, &[200], -56.0, -56.0),
            (VoxelType::I16, &[1, 255], -255.0, 511.0),
            (VoxelType::U32, &[0, 0, 0, 128], 2_147_483_648.0, 128.0),
            (VoxelType::F32, &[0, 0, 128, 63], 1.0, f64::from(f32::from_bits(0x803f))),
            (VoxelType::F64, &[0; 8], 0.0, 0.0),
            (VoxelType::I32, &[1], 0.0, 0.0),
        ] {
            assert_eq!([decode(kind, false, bytes), decode(kind, true, bytes)], [little, big], "{kind}");
        }
        let mut four = [0; 4];
        assert_eq!((fill(&mut &[1, 2, 3][..], &mut four).unwrap(), four), (3, [1, 2, 3, 0]));
    }
}
