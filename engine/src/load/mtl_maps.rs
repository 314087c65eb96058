//! The textures that a material of an MTL file names: `map_Kd -s 2 2 cloth.jpg`.

use super::text;
use crate::texture::Wrap;

/// A statement about a texture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapStatement {
    /// What the file is called.
    pub(super) name: String,
    /// How often the texture repeats for each unit of the texture coordinates (`-s`), and where it begins (`-o`).
    pub(super) scale: [f32; 2],
    pub(super) offset: [f32; 2],
    /// Beyond its borders (`-clamp`).
    pub(super) wrap: Wrap,
    /// How high bumps are (`-bm`).
    pub(super) bump: f32,
    /// Does the opacity come from the alpha of the picture (`-imfchan m`)?
    pub(super) matte: bool,
}

impl MapStatement {
    /// The options, and the name, which may have blanks in it; `None` without a name. Options that are unknown or broken are left out.
    pub(super) fn parse(statement: &str) -> Option<Self> {
        let mut found = Self {
            name: String::new(),
            scale: [1.0; 2],
            offset: [0.0; 2],
            wrap: Wrap::Repeat,
            bump: 1.0,
            matte: false,
        };
        let mut rest = statement.trim();
        while let Some((option, after)) = word(rest).filter(|(option, _)| option.starts_with('-')) {
            rest = after;
            match option {
                "-s" | "-o" | "-t" => {
                    let mut numbers = [None; 3];
                    for number in &mut numbers {
                        let Some((word, after)) = word(rest) else { break };
                        let Some(value) =
                            text::number(word).map(|value| value as f32).filter(|value| value.is_finite())
                        else {
                            break;
                        };
                        (*number, rest) = (Some(value), after);
                    }
                    let usual = if option == "-s" { 1.0 } else { 0.0 };
                    let pair = [numbers[0].unwrap_or(usual), numbers[1].unwrap_or(usual)];
                    match option {
                        "-s" => found.scale = pair,
                        "-o" => found.offset = pair,
                        _ => {}
                    }
                }
                "-mm" => (0..2).for_each(|_| rest = word(rest).map_or("", |(_, after)| after)),
                "-blendu" | "-blendv" | "-boost" | "-texres" | "-cc" | "-type" | "-clamp" | "-bm" | "-imfchan" => {
                    let Some((value, after)) = word(rest) else { break };
                    rest = after;
                    match (option, value) {
                        ("-clamp", "on") => found.wrap = Wrap::Clamp,
                        ("-imfchan", "m") => found.matte = true,
                        ("-bm", number) => {
                            let number = text::number(number).map(|value| value as f32);
                            found.bump = number.filter(|value| value.is_finite()).unwrap_or(1.0);
                        }
                        _ => {}
                    }
                }
                _ => {}
            }
        }
        let bare = rest.split_once(" #").map_or(rest, |(name, _)| name.trim());
        found.name = bare.trim_matches(['"', '\'']).to_owned();
        (!found.name.is_empty()).then_some(found)
    }
}

/// The first word, and what follows it.
fn word(text: &str) -> Option<(&str, &str)> {
    let text = text.trim_start();
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (!word.is_empty()).then_some((word, rest.trim_start()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_have_options_and_a_name() {
        let plain = MapStatement::parse("  my wood.jpg\t\t").unwrap();
        assert_eq!((&*plain.name, plain.scale, plain.offset), ("my wood.jpg", [1.0; 2], [0.0; 2]));
        let all =
            MapStatement::parse("-blendu on -s 2 3 1 -o .5 -clamp on -bm 0.25 -mm 0 1 -imfchan m \"a b.png\"").unwrap();
        assert_eq!((&*all.name, all.scale, all.offset), ("a b.png", [2.0, 3.0], [0.5, 0.0]));
        assert_eq!((all.wrap, all.bump, all.matte), (Wrap::Clamp, 0.25, true));
        // A name that begins like a number, numbers that are none, options that nobody knows.
        assert_eq!(MapStatement::parse("-s 4 4 4x.png").unwrap().name, "4x.png");
        assert_eq!(MapStatement::parse("-s nan inf x.png").unwrap().scale, [1.0; 2]);
        assert_eq!(MapStatement::parse("-what x.png").unwrap().name, "x.png");
        for nothing in ["", "  ", "-s", "-s 1 2", "-clamp", "-bm", "-mm 1", "\"\"", "-"] {
            assert_eq!(MapStatement::parse(nothing), None, "{nothing:?}");
        }
    }
}
