//! Components that are chosen by name at run time: one line each in a table, and an error that lists the names.

/// A name that no component has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no {kind} is called \"{name}\"; there are: {known}")]
pub struct UnknownName {
    /// What was to be chosen: "renderer".
    pub kind: &'static str,
    /// What was asked for.
    pub name: String,
    /// What there is.
    pub known: String,
}

/// Names as people list them: "a, b or c".
pub fn list(names: &[&str]) -> String {
    match names {
        [one] => (*one).to_owned(),
        [others @ .., last] => format!("{} or {last}", others.join(", ")),
        [] => String::new(),
    }
}

/// Defines an enum whose variants have names: `ALL`, `NAMES`, `name`, `FromStr` (upper and lower case are the same), `Display`. With `-> Trait` in the head, and
/// `=> value` in each line, `build` makes the component.
macro_rules! choice {
    ($(#[$outer:meta])* $kind:literal $type:ident $(($($argument:ident: $of:ty),+))? -> $trait:path {
        $($(#[$inner:meta])* $variant:ident = $name:literal => $value:expr,)+
    }) => {
        $crate::choice::choice! { $(#[$outer])* $kind $type { $($(#[$inner])* $variant = $name,)+ } }

        impl $type {
            /// Makes it.
            pub fn build(self $($(, $argument: $of)+)?) -> std::sync::Arc<dyn $trait> {
                match self {
                    $(Self::$variant => std::sync::Arc::new($value),)+
                }
            }
        }
    };
    ($(#[$outer:meta])* $kind:literal $type:ident { $($(#[$inner:meta])* $variant:ident = $name:literal,)+ }) => {
        $(#[$outer])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $type {
            $($(#[$inner])* $variant,)+
        }

        impl $type {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant,)+];

            /// Their names.
            pub const NAMES: &[&str] = &[$($name,)+];

            /// Its name.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }

        impl std::str::FromStr for $type {
            type Err = $crate::choice::UnknownName;
            fn from_str(name: &str) -> Result<Self, Self::Err> {
                Self::ALL.iter().copied().find(|choice| choice.name().eq_ignore_ascii_case(name)).ok_or_else(|| {
                    let known = Self::NAMES.join(", ");
                    $crate::choice::UnknownName { kind: $kind, name: name.to_owned(), known }
                })
            }
        }

        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}
pub(crate) use choice;

#[cfg(test)]
mod tests {
    use super::list;

    #[test]
    fn names_are_listed() {
        assert_eq!(list(&["a", "b", "c"]), "a, b or c");
        assert_eq!(list(&["a"]), "a");
    }
}
