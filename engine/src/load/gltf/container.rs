//! The parts of a GLB file (glTF 2.0, section 4.4), and the bytes that a document names.

use std::borrow::Cow;
use std::path::Path;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use crate::load::beside::beside;
use crate::load::text::quoted;

/// How a GLB file starts.
pub(super) const MAGIC: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BINARY: &[u8] = b"BIN\0";

/// A document, and the bytes behind it, if it is a GLB file.
pub(super) fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let number = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?));
    let (Some(version), Some(_length)) = (number(4), number(8)) else {
        return Err("the file ends in its header".into());
    };
    if version != 2 {
        return Err(format!("this is version {version} of GLB, not 2"));
    }
    let mut rest = &bytes[12..];
    let mut chunk = |kind: &[u8]| {
        let length = u32::from_le_bytes(*rest.first_chunk()?) as usize;
        let named = rest.get(4..8)? == kind;
        let data = rest.get(8..)?.get(..length).filter(|_| named)?;
        rest = &rest[8 + length..];
        Some(data)
    };
    match chunk(JSON) {
        Some(json) => Ok((json, chunk(BINARY))),
        None => Err("the file ends in its JSON part".into()),
    }
}

/// The bytes that a URI stands for: in itself, or in a file beside the document.
pub(super) fn fetch(document: &Path, uri: &str) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, packed) = data.split_once(";base64,").ok_or("a data URI is not base64")?;
        let lenient = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
        let decoded = GeneralPurpose::new(&STANDARD, lenient).decode(packed);
        return decoded.map_err(|error| format!("a data URI is damaged ({error})"));
    }
    if uri.contains("://") {
        return Err(format!("{} is not fetched: save it beside the document", quoted(uri)));
    }
    let name: Cow<'_, str> = percent_decode_str(uri).decode_utf8_lossy();
    let file = beside(document, &name)
        .ok_or_else(|| format!("{} is not there (only files beside the document are read)", quoted(&name)))?;
    std::fs::read(&file).map_err(|error| format!("{} cannot be read: {error}", quoted(&name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_binary_files() {
        let glb = |json: &[u8], bin: Option<&[u8]>| {
            let mut bytes = [MAGIC, &2_u32.to_le_bytes(), &0_u32.to_le_bytes()].concat();
            for (kind, data) in [(JSON, Some(json)), (BINARY, bin)] {
                let Some(data) = data else { continue };
                bytes.extend((data.len() as u32).to_le_bytes());
                bytes.extend(kind);
                bytes.extend(data);
            }
            bytes
        };
        assert_eq!(split(b"{}"), Ok((&b"{}"[..], None)));
        assert_eq!(split(&glb(b"{}", None)), Ok((&b"{}"[..], None)));
        let whole = glb(b"{ }x", Some(b"1234"));
        assert_eq!(split(&whole), Ok((&b"{ }x"[..], Some(&b"1234"[..]))));
        for end in 4..24 {
            assert!(split(&whole[..end]).is_err(), "{end}");
        }
        // Cut in the binary part, which then is not there.
        assert_eq!(split(&whole[..whole.len() - 1]), Ok((&b"{ }x"[..], None)));
    }

    #[test]
    fn bytes_in_uris() {
        let fetch = |uri| fetch(Path::new("/nowhere/x.gltf"), uri);
        assert_eq!(fetch("data:application/octet-stream;base64,AAEC/w=="), Ok(vec![0, 1, 2, 255]));
        assert_eq!(fetch("data:;base64,AAEC/w"), Ok(vec![0, 1, 2, 255]));
        for bad in
            ["data:,abc", "data:;base64,*", "a.bin", "../../etc/passwd", "/etc/passwd", "https://example.org/a.bin"]
        {
            assert!(fetch(bad).is_err(), "{bad}");
        }
    }
}
