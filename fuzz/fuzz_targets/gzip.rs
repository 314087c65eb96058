//! Any bytes as a gzipped OBJ file: as they are, after a sound header, or soundly packed, when they must load as the
//! same bytes unpacked do.
#![no_main]

mod files;

use std::io::Write;

use flate2::{Compression, write::GzEncoder};
use libfuzzer_sys::fuzz_target;

const HEADER: [u8; 10] = [0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3];

fuzz_target!(|bytes: &[u8]| {
    let Some((how, bytes)) = bytes.split_first() else { return };
    match how % 3 {
        0 => drop(files::load(&files::write("fuzz.obj.gz", bytes))),
        1 => drop(files::load(&files::write("fuzz.obj.gz", &[&HEADER, bytes].concat()))),
        // What is gzip already would be unpacked once in either way.
        _ if !bytes.starts_with(&HEADER[..2]) => {
            let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
            encoder.write_all(bytes).unwrap();
            // Both may name the plain file as a file of materials: neither finds it.
            files::remove("fuzz.obj");
            let packed = files::load(&files::write("fuzz.obj.gz", &encoder.finish().unwrap()));
            let plain = files::load(&files::write("plain.obj", bytes));
            files::remove("plain.obj");
            match (packed, plain) {
                (Ok(packed), Ok(plain)) => assert_eq!(packed.report.census, plain.report.census),
                // Text that shrinks to less than a thirtieth is refused packed.
                (Err(packed), _) if packed.problem.contains("unpacks to more") => {}
                (Err(packed), Err(plain)) => assert_eq!(packed.line, plain.line, "{packed} {plain}"),
                (Err(packed), Ok(_)) => panic!("only plain it loads: {packed}"),
                (Ok(_), Err(plain)) => panic!("only packed it loads: {plain}"),
            }
        }
        _ => {}
    }
});
