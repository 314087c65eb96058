//! The checker on small crates that were made up for it.

use crate::rules::violations;
use crate::source::Files;

/// The names and places of all violations in a crate of these files.
fn check(files: &[(&str, &str)]) -> Vec<(String, String)> {
    let files: Files = files.iter().map(|&(file, text)| (file.into(), text.into())).collect();
    violations("p", &files).into_iter().map(|violation| (violation.name, violation.places)).collect()
}

/// The names of all violations in a crate whose root declares and maps the modules `a` and `b`, `a` above, and goes on as
/// given.
fn names(root: &str, others: &[(&str, &str)]) -> Vec<String> {
    let root = format!(
        "//! # Map\n//! | module | idea |\n//! |---|---|\n//! | [`a`], [`b`] | x |\npub mod a; pub mod b;\n{root}"
    );
    let files: Vec<_> = [("lib.rs", root.as_str())].into_iter().chain(others.iter().copied()).collect();
    check(&files).into_iter().map(|(name, _)| name).collect()
}

const CYCLE: &str = "p: cycle a.rs -> b.rs -> a.rs";
const UPWARD: &str = "p: b uses a, which stands above it";

#[test]
fn what_uses_only_what_is_below_is_right() {
    let a = "use crate::b::B; pub struct A(B);";
    assert!(names("", &[("a.rs", a), ("b.rs", "use std::fmt; pub struct B;")]).is_empty());
}

#[test]
fn a_cycle_is_found_with_its_lines() {
    let map = "//! # Map\n//! | [`a`] | x |\n//! | [`b`] | x |\n//! | [`c`] | x |\npub mod a; pub mod b; pub mod c;";
    let a = "pub struct A;\nuse crate::b::B;";
    let c = "\n\nfn f() { crate::a::A; }";
    let found = check(&[("lib.rs", map), ("a.rs", a), ("b.rs", "use crate::c::C;\npub struct B;"), ("c.rs", c)]);
    let want = [
        ("p: c uses a, which stands above it".to_string(), "    p/src/c.rs:3: crate::a::A\n".to_string()),
        (
            "p: cycle a.rs -> b.rs -> c.rs -> a.rs".to_string(),
            "    p/src/a.rs:2: crate::b::B\n    p/src/b.rs:1: crate::c::C\n    p/src/c.rs:3: crate::a::A\n".to_string(),
        ),
    ];
    assert_eq!(found, want);
}

#[test]
fn a_cycle_is_found_through_every_form_of_import() {
    let b = "pub struct B; pub fn b() {}";
    for back in [
        "use crate::a::A;",
        "use crate::{a::{A as Other}};",
        "use super::a::A;",
        "use crate::a::*;",
        "pub use crate::a::A;",
        "pub use crate::a::*;",
        "use crate::a; fn f(_: &a::A) {}",
        "use crate::a::{self}; fn f(_: &a::A) {}",
        "use super::*; fn f(_: &a::A) {}",
        "fn f() { use crate::a::A; }",
        "fn f() { use crate::a; g(a::a()) }",
        "fn f() -> u8 { crate::a::a() }",
        "fn f() { vec![super::a::A] }",
        "fn f(n: u8) { g(0..crate::a::C) }",
        "macro_rules! m { () => { $crate::a::A } }",
        "macro_rules! m { () => { use $crate::a::A; } }",
        "impl From<u8> for crate::a::A {}",
        "enum E { One(crate::a::A) }",
        "mod inner { use super::super::a::A; }",
        "mod inner { fn f() { crate::a::made_by_a_macro() } }",
    ] {
        let a = "use crate::b::B; pub struct A; pub fn a() -> u8 { 0 } pub const C: u8 = 1;";
        assert_eq!(names("", &[("a.rs", a), ("b.rs", &format!("{b} {back}"))]), [UPWARD, CYCLE], "{back}");
    }
}

#[test]
fn a_re_export_is_followed_to_the_defining_file() {
    let a = "use crate::b::B; pub struct A; #[macro_export] macro_rules! make { () => {} }";
    for (root, b) in [
        ("pub use a::A;", "use crate::A;"),
        ("pub use a::A as Other;", "fn f() { crate::Other }"),
        ("pub use a::*;", "use crate::A;"),
        ("pub use self::a::{A};", "use super::A;"),
        ("mod middle { pub use crate::a::A; }", "use crate::middle::A;"),
        ("", "crate::make!();"),
    ] {
        let b = format!("pub struct B; {b}");
        assert_eq!(names(root, &[("a.rs", a), ("b.rs", &b)]), [UPWARD, CYCLE], "{root} {b}");
    }
}

#[test]
fn a_name_of_two_things_is_each_where_it_fits() {
    // `a` is a module and, at the root, what it defines.
    let (root, a) = ("pub use a::a;", "pub fn a() {} pub struct A;");
    assert_eq!(names(root, &[("a.rs", a), ("b.rs", "use crate::a;  fn f() { a() }")]), [UPWARD]);
    assert_eq!(names(root, &[("a.rs", a), ("b.rs", "use crate::a::A;")]), [UPWARD]);
    assert!(names(root, &[("a.rs", "use crate::b; fn f() { b::g() }"), ("b.rs", "pub fn g() {}")]).is_empty());
}

#[test]
fn tests_may_use_anything() {
    let a = "use crate::b::B; pub struct A;";
    for b in [
        "#[cfg(test)] mod tests { use crate::a::A; }",
        "#[cfg(test)] mod in_a_file_that_is_not_read;",
        "#[cfg(all(test, not(loom)))] mod tests { use crate::a::A; }",
        "#[test] fn t() { crate::a::A; }",
        "#[cfg(test)] use crate::a::A;",
        "#[cfg(test)] impl B { fn f() { crate::a::A; } }",
        "impl B { #[cfg(test)] fn f() { crate::a::A; } fn g() {} }",
    ] {
        let b = format!("pub struct B; {b}");
        assert!(names("", &[("a.rs", a), ("b.rs", &b)]).is_empty(), "{b}");
    }
    for b in [
        "#[cfg(not(test))] use crate::a::A;",
        "#[cfg(any(test, unix))] use crate::a::A;",
        "impl B { #[cfg(test)] fn f() {} fn g() { crate::a::A; } }",
        "impl B { #[cfg(feature = \"test\")] fn f() { crate::a::A; } }",
    ] {
        let b = format!("pub struct B; {b}");
        assert_eq!(names("", &[("a.rs", a), ("b.rs", &b)]), [UPWARD, CYCLE], "{b}");
    }
}

#[test]
fn what_only_looks_like_a_path_is_none() {
    let a = "use crate::b::B; pub struct A; pub fn a() {} pub struct Name;";
    for b in [
        "/// [`crate::a::A`]\npub struct Documented;",
        "fn f() { \"crate::a::A\" }",
        "fn f(x: X) { x.a.A }",
        "fn f(x: X) { X::crate_a::A }",
        "use std::a::A; fn f(_: ::other::a::A) {}",
        "pub(crate) struct Other; pub(in crate::b) struct Third;",
    ] {
        let b = format!("pub struct B; {b}");
        assert!(names("pub use a::{A, Name};", &[("a.rs", a), ("b.rs", &b)]).is_empty(), "{b}");
    }
}

#[test]
fn a_parent_may_declare_and_re_export_what_a_child_of_it_uses() {
    let child = "use super::Own; use crate::a::Also; pub struct Child; pub struct Other;";
    let parent = "mod child; mod second; pub use child::{Child, Other as Renamed}; pub struct Own; pub struct Also;
        pub enum Kind { #[default] Child, Renamed(u8) } pub fn f(kind: Kind) { g(Kind::Child) }
        impl Own { type Child = u8; fn child(&self) { self.child() } }";
    let others = [("a/child.rs", child), ("a/second.rs", "use super::child::Child;"), ("b.rs", "")];
    let files: Vec<_> = [("a/mod.rs", parent)].into_iter().chain(others).collect();
    assert!(names("pub use a::{Own, Child};", &files).is_empty());
}

#[test]
fn a_parent_that_uses_a_child_of_it_must_not_be_used_by_it() {
    let cycle = "p: cycle a/child.rs -> a/mod.rs -> a/child.rs";
    for used in [
        "use child::Child;",
        "pub use child::Child; pub struct More(Child);",
        "pub use child::f; pub fn g() { f() }",
        "pub fn g() { child::f() }",
        "pub fn g() { self::child::f::<u8>() }",
        "pub enum Kind { Child(crate::a::child::Child) }",
    ] {
        let parent = format!("mod child; pub struct Own; {used}");
        let files = [("a/mod.rs", parent.as_str()), ("a/child.rs", "use super::Own; pub struct Child;"), ("b.rs", "")];
        assert_eq!(names("", &files), [cycle], "{used}");
        let child = ("a/child.rs", "use crate::b::X; pub struct Child;");
        assert!(names("", &[files[0], child, files[2]]).is_empty(), "{used}");
    }
}

#[test]
fn what_the_root_defines_is_a_file_like_others() {
    let a = "use crate::Own;";
    let files = [("a.rs", a), ("b.rs", "pub struct B;")];
    assert!(names("pub struct Own; pub use b::B;", &files).is_empty());
    assert_eq!(names("pub struct Own(a::A);", &files), ["p: cycle a.rs -> lib.rs -> a.rs"]);
}

#[test]
fn the_map_must_be_there_and_complete() {
    let found = |root: &str| -> Vec<String> {
        let others = [("a.rs", ""), ("b.rs", "")];
        let files: Vec<_> = [("lib.rs", root)].into_iter().chain(others).collect();
        check(&files).into_iter().map(|(name, _)| name).collect()
    };
    assert_eq!(found("//! | [`a`] | x |\n//! | [`b`] | y |\npub mod a; pub mod b;"), ["p: no map"]);
    assert_eq!(found("//! # Map\n//! words\n//!\n//! | [`a`] | x |\npub mod a; pub mod b;"), ["p: the map lacks b"]);
    assert!(found("//! # Map\n//! | [`a`](mod@a) | [`x`] |\n//! words, `y`\npub mod a; mod b;").is_empty());
    assert_eq!(
        found("//! # Map\n//! | `a`, [`b`], [`c`], [`simd`] |\n//! | `a` |\npub mod a; mod b; pub use other as simd;"),
        ["p: the map names a twice", "p: the map names c, which does not exist"]
    );
}
