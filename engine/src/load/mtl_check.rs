//! What an MTL line must look like before the parser sees it.

use super::error::quoted;
use super::lines::{Fault, LineCheck};

const NUMBERS: &str = "write plain numbers such as 0.25";

/// What has been seen of an MTL file.
#[derive(Debug, Default)]
pub(super) struct MtlCheck {
    /// Materials so far.
    pub(super) materials: u64,
    /// Texture maps, which are left out.
    pub(super) textures: u64,
    /// Statements of unknown meaning, which are left out.
    pub(super) unknown: u64,
    /// Has the current material a `d`? It wins over `Tr`, which exporters disagree about.
    dissolve: bool,
}

impl LineCheck for MtlCheck {
    fn check(&mut self, _: u64, line: &mut String) -> Result<(), Fault> {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else {
            line.clear();
            return Ok(());
        };
        let lower = keyword.to_ascii_lowercase();
        let rewritten = match lower.as_str() {
            "newmtl" => {
                let name = line.trim()[keyword.len()..].trim();
                if name.is_empty() {
                    return Err(Fault::new("newmtl without a name", "write newmtl NAME"));
                }
                self.materials += 1;
                self.dissolve = false;
                format!("newmtl {name}")
            }
            "ka" | "kd" | "ks" | "ke" => match colour(keyword, words)? {
                Some([r, g, b]) => format!("K{} {r} {g} {b}", &lower[1..]),
                None => {
                    self.unknown += 1;
                    String::new()
                }
            },
            "ns" => format!("Ns {}", number(keyword, words.next())?),
            "ni" => format!("Ni {}", number(keyword, words.next())?),
            // `d -halo 0.5` is dissolve that depends on the angle; `Tr` is one minus dissolve.
            "d" => {
                self.dissolve = true;
                format!("d {}", number(keyword, words.find(|word| *word != "-halo"))?)
            }
            "tr" => {
                let transparency = number(keyword, words.next())?;
                if self.dissolve { String::new() } else { format!("d {}", 1.0 - transparency) }
            }
            "illum" => {
                let model = number(keyword, words.next())?;
                if (0.0..=255.0).contains(&model) { format!("illum {model:.0}") } else { String::new() }
            }
            _ => {
                if lower.starts_with("map_") || matches!(lower.as_str(), "bump" | "disp" | "decal" | "refl" | "norm") {
                    self.textures += 1;
                } else if !keyword.starts_with('#') {
                    self.unknown += 1;
                }
                String::new()
            }
        };
        *line = rewritten;
        Ok(())
    }
}

/// A finite number; MTL has no use for others.
fn number(keyword: &str, word: Option<&str>) -> Result<f32, Fault> {
    let Some(word) = word else {
        return Err(Fault::new(format!("{keyword} without a number"), NUMBERS));
    };
    match word.parse::<f32>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(Fault::new(format!("{keyword} {} is not a finite number", quoted(word)), NUMBERS)),
    }
}

/// `r [g b]`; the other forms (`spectral`, `xyz`) mean nothing to us.
fn colour<'a>(keyword: &str, mut words: impl Iterator<Item = &'a str>) -> Result<Option<[f32; 3]>, Fault> {
    let first = words.next();
    if matches!(first, Some("spectral" | "xyz")) {
        return Ok(None);
    }
    let r = number(keyword, first)?;
    let mut rest = [r; 2];
    for (value, word) in rest.iter_mut().zip(words) {
        *value = number(keyword, Some(word))?;
    }
    Ok(Some([r, rest[0], rest[1]]))
}
