//! What an MTL line must look like before the parser sees it.

use std::path::Path;

use super::lines::{Fault, LineCheck};
use super::obj_read::Seen;
use super::text::{self, quoted};

/// Of a file with more materials no more are read: each takes some hundred bytes, a statement takes ten.
const MOST_MATERIALS: u64 = 1 << 16;

/// Textures that are used: their keywords, in lower case, and what the parser is told, which hands on what it does not know.
pub(super) const TEXTURES: [(&[&str], &str); 8] = [
    (&["map_kd"], "texture:color"),
    (&["map_ks"], "texture:specular"),
    (&["map_ke"], "texture:emission"),
    (&["map_pr"], "texture:roughness"),
    (&["map_pm"], "texture:metallic"),
    (&["map_d", "map_tr", "map_opacity"], "texture:opacity"),
    (&["map_bump", "bump"], "texture:bumps"),
    (&["norm", "map_kn", "map_norm"], "texture:normals"),
];

/// What has been seen of an MTL file.
#[derive(Debug, Default)]
pub(super) struct MtlCheck {
    /// Materials so far.
    pub(super) materials: u64,
    /// Was it written by Blender?
    pub(super) blender: bool,
    /// Textures that mean nothing to us, which are left out.
    textures: u64,
    /// Lines that say nothing that can be understood, which are left out, and what the first of them is.
    odd: Seen,
    first_odd: String,
    /// Has the current material no name? Its lines are left out.
    nameless: bool,
    /// Has the current material a `d`? It wins over `Tr`, which exporters disagree about.
    dissolve: bool,
}

impl LineCheck for MtlCheck {
    fn joins(line: &[u8]) -> bool {
        !line.contains(&b'#') && !line.trim_ascii_start().starts_with(b"newmtl")
    }

    fn check(&mut self, number: u64, line: &mut String) -> Result<(), Fault> {
        let rewritten = self.rewrite(line.trim());
        *line = match rewritten {
            Ok(line) => line,
            Err(problem) => {
                if self.odd.count == 0 {
                    self.first_odd = problem;
                }
                self.odd.at(number);
                String::new()
            }
        };
        if self.materials > MOST_MATERIALS {
            return Err(Fault::new(
                format!("there are more than {MOST_MATERIALS} materials"),
                "leave out those that are not used",
            ));
        }
        Ok(())
    }
}

impl MtlCheck {
    /// What people should know.
    pub(super) fn warnings(&self, file: &Path) -> impl Iterator<Item = String> {
        let file = file.display();
        let textures = (self.textures > 0).then(|| {
            let (count, s, is) = (
                self.textures,
                if self.textures == 1 { "" } else { "s" },
                if self.textures == 1 { "is" } else { "are" },
            );
            format!("{file}: {count} texture map{s} of other kinds than Mobula knows {is} left out")
        });
        let Seen { count, line } = self.odd;
        let odd = (count > 0).then(|| {
            let others = match count - 1 {
                0 => String::new(),
                1 => ", and one other".to_owned(),
                others => format!(", and {others} others"),
            };
            format!("{file}:{line}: {}; the line is left out{others}", self.first_odd)
        });
        [textures, odd].into_iter().flatten()
    }

    /// A line that the parser knows, or nothing, or what is wrong.
    fn rewrite(&mut self, line: &str) -> Result<String, String> {
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        self.blender |= keyword.starts_with('#') && line.contains("Blender");
        let mut words = rest.split_whitespace();
        let lower = keyword.to_ascii_lowercase();
        if lower == "newmtl" {
            let name = rest.trim();
            self.nameless = name.is_empty();
            self.dissolve = false;
            if self.nameless {
                return Err("newmtl without a name".into());
            }
            self.materials += 1;
            return Ok(format!("newmtl {name}"));
        }
        if self.nameless {
            return Ok(String::new());
        }
        Ok(match lower.as_str() {
            "ka" | "kd" | "ks" | "ke" => match colour(keyword, words)? {
                Some([r, g, b]) => format!("K{} {r} {g} {b}", &lower[1..]),
                None => String::new(),
            },
            "ns" => format!("Ns {}", number(keyword, words.next())?),
            "ni" => format!("Ni {}", number(keyword, words.next())?),
            // Numbers that the parser does not know: it hands them on.
            "pr" => format!("roughness {}", number(keyword, words.next())?),
            "pm" => format!("metallic {}", number(keyword, words.next())?),
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
            other => match TEXTURES.iter().find(|(keywords, _)| keywords.contains(&other)) {
                Some((_, name)) => format!("{name} {}", rest.trim()),
                None => {
                    let texture = lower.starts_with("map_") || matches!(other, "disp" | "decal" | "refl");
                    self.textures += u64::from(texture);
                    String::new()
                }
            },
        })
    }
}

/// A finite number; MTL has no use for others.
fn number(keyword: &str, word: Option<&str>) -> Result<f32, String> {
    let word = word.ok_or_else(|| format!("{} without a number", text::printable(keyword)))?;
    match text::number(word).map(|value| value as f32) {
        Some(value) if value.is_finite() => Ok(value),
        _ => Err(format!("{} {} is not a finite number", text::printable(keyword), quoted(word))),
    }
}

/// `r [g b]`; the other forms (`spectral`, `xyz`) mean nothing to us.
fn colour<'a>(keyword: &str, mut words: impl Iterator<Item = &'a str>) -> Result<Option<[f32; 3]>, String> {
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
