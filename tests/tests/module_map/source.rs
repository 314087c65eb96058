//! The modules of a crate as its files declare them: what each defines, re-exports and says, without its tests.

use std::collections::BTreeMap;

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::{Attribute, Item, ItemUse, Meta, Token, UseTree, Visibility};

/// The files of a crate by their path below `src`, with `/` between folders.
pub(crate) type Files = BTreeMap<String, String>;

/// A module, in a file of its own or inside one.
#[derive(Default)]
pub(crate) struct Module {
    /// The file that it stands in.
    pub(crate) file: String,
    /// The module that it is a child of; none for the root.
    pub(crate) parent: Option<usize>,
    /// Visible to other crates, as far as its own declaration says.
    pub(crate) public: bool,
    /// What its names mean. A name may mean several things: a module and a function, say.
    pub(crate) names: BTreeMap<String, Vec<Meaning>>,
    /// Every `use`, one for each name that it brings.
    pub(crate) uses: Vec<Use>,
    /// The tokens of its items, in which paths are looked for.
    pub(crate) bodies: Vec<TokenStream>,
    /// Its inner documentation, a line each.
    pub(crate) doc: Vec<String>,
}

/// What a name of a module stands for.
#[derive(Clone, Copy)]
pub(crate) enum Meaning {
    /// What the module of this number defines: this one, unless a macro is exported to the root.
    Item(usize),
    /// A child module.
    Module(usize),
    /// The `use` of this number.
    Use(usize),
}

/// One name that a `use` brings into a module, or a glob.
pub(crate) struct Use {
    /// As written, without the last `as`.
    pub(crate) path: Vec<String>,
    /// `path::*`.
    pub(crate) glob: bool,
    /// It has a visibility, and so re-exports.
    pub(crate) public: bool,
    /// Where it stands.
    pub(crate) line: usize,
}

/// The modules of a crate; the first is its root.
///
/// # Panics
/// If a file is missing, is not Rust, or stands where this does not look (`#[path]`).
pub(crate) fn modules(files: &Files) -> Vec<Module> {
    let mut modules = Vec::new();
    read_file(files, "lib.rs", "", None, &mut modules);
    modules
}

/// What a file holds: its inner attributes, and its items beside their tokens.
struct Source {
    attributes: Vec<Attribute>,
    items: Vec<(Item, TokenStream)>,
}

impl Parse for Source {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let attributes = input.call(Attribute::parse_inner)?;
        let mut items = Vec::new();
        while !input.is_empty() {
            let before = input.fork();
            let item = input.parse()?;
            let mut tokens = TokenStream::new();
            while before.cursor() != input.cursor() {
                tokens.extend([before.parse::<TokenTree>()?]);
            }
            items.push((item, tokens));
        }
        Ok(Self { attributes, items })
    }
}

/// Reads a module that has a file of its own; `folder` is where its children's files are.
fn read_file(files: &Files, file: &str, folder: &str, parent: Option<usize>, modules: &mut Vec<Module>) -> usize {
    let text = files.get(file).unwrap_or_else(|| panic!("{file} is missing"));
    let source = syn::parse_str(text).unwrap_or_else(|error| panic!("{file}:{}: {error}", error.span().start().line));
    read(files, source, file, folder, parent, modules)
}

fn read(
    files: &Files,
    source: Source,
    file: &str,
    folder: &str,
    parent: Option<usize>,
    modules: &mut Vec<Module>,
) -> usize {
    let this = modules.len();
    let doc = source.attributes.iter().filter_map(doc_line).collect();
    modules.push(Module { file: file.into(), parent, doc, ..Module::default() });
    for (item, tokens) in source.items {
        if attributes(&item).iter().any(is_test) {
            continue;
        }
        let name = match &item {
            Item::Use(item) => {
                read_use(item, &mut modules[this]);
                continue;
            }
            Item::Mod(item) => {
                assert!(!item.attrs.iter().any(|a| a.path().is_ident("path")), "{file}: #[path] is not understood");
                let name = item.ident.to_string();
                let inner = format!("{folder}{name}/");
                let child = match tokens.into_iter().last() {
                    Some(TokenTree::Group(body)) => {
                        let source = syn::parse2(body.stream()).unwrap_or_else(|error| panic!("{file}: {error}"));
                        read(files, source, file, &inner, Some(this), modules)
                    }
                    _ => {
                        let beside = format!("{folder}{name}.rs");
                        let own = if files.contains_key(&beside) { beside } else { format!("{inner}mod.rs") };
                        read_file(files, &own, &inner, Some(this), modules)
                    }
                };
                modules[child].public = matches!(item.vis, Visibility::Public(_));
                modules[this].names.entry(name).or_default().push(Meaning::Module(child));
                continue;
            }
            Item::Const(item) => Some(&item.ident),
            Item::Enum(item) => Some(&item.ident),
            Item::Fn(item) => Some(&item.sig.ident),
            Item::Macro(item) => item.ident.as_ref(),
            Item::Static(item) => Some(&item.ident),
            Item::Struct(item) => Some(&item.ident),
            Item::Trait(item) => Some(&item.ident),
            Item::TraitAlias(item) => Some(&item.ident),
            Item::Type(item) => Some(&item.ident),
            Item::Union(item) => Some(&item.ident),
            _ => None,
        };
        if let Some(name) = name {
            let exported = attributes(&item).iter().any(|a| a.path().is_ident("macro_export"));
            let at = if exported { 0 } else { this };
            modules[at].names.entry(name.to_string()).or_default().push(Meaning::Item(this));
        }
        let tokens = if matches!(item, Item::Enum(_)) { without_variants(tokens) } else { tokens };
        read_inner_uses(tokens.clone(), &mut modules[this]);
        modules[this].bodies.push(tokens);
    }
    this
}

/// Every name that a `use` brings.
fn read_use(item: &ItemUse, module: &mut Module) {
    let line = item.use_token.span.start().line;
    let public = !matches!(item.vis, Visibility::Inherited);
    read_tree(&item.tree, &mut Vec::new(), &mut |path: &[String], name: Option<String>| {
        let of_parent = path.last().is_some_and(|last| last == "self") && path.len() > 1;
        let path = if of_parent { &path[..path.len() - 1] } else { path };
        if let Some(name) = &name {
            let name = if of_parent && name == "self" { &path[path.len() - 1] } else { name };
            let meaning = Meaning::Use(module.uses.len());
            module.names.entry(name.clone()).or_default().push(meaning);
        }
        module.uses.push(Use { path: path.to_vec(), glob: name.is_none(), public, line });
    });
}

/// Calls `found` with each path of a tree and its name; without a name for a glob.
fn read_tree(tree: &UseTree, path: &mut Vec<String>, found: &mut impl FnMut(&[String], Option<String>)) {
    let depth = path.len();
    match tree {
        UseTree::Path(tree) => {
            path.push(tree.ident.to_string());
            read_tree(&tree.tree, path, found);
        }
        UseTree::Name(tree) => {
            path.push(tree.ident.to_string());
            found(path, Some(tree.ident.to_string()));
        }
        UseTree::Rename(tree) => {
            path.push(tree.ident.to_string());
            found(path, Some(tree.rename.to_string()));
        }
        UseTree::Glob(_) => found(path, None),
        UseTree::Group(tree) => tree.items.iter().for_each(|tree| read_tree(tree, path, found)),
    }
    path.truncate(depth);
}

/// Each `use` inside a function or a macro, as if it stood in the module.
fn read_inner_uses(tokens: TokenStream, module: &mut Module) {
    let mut tokens = tokens.into_iter();
    while let Some(token) = tokens.next() {
        match token {
            TokenTree::Group(group) => read_inner_uses(group.stream(), module),
            TokenTree::Ident(ident) if ident == "use" => {
                let mut item = TokenStream::from(TokenTree::Ident(ident));
                for token in tokens.by_ref() {
                    let (dollar, end) = (is_punct(&token, '$'), is_punct(&token, ';'));
                    if !dollar {
                        item.extend([token]);
                    }
                    if end {
                        break;
                    }
                }
                // What a macro writes may be no `use` yet.
                if let Ok(item) = syn::parse2::<ItemUse>(item) {
                    read_use(&item, module);
                }
            }
            _ => {}
        }
    }
}

/// An enum's tokens without the names of its variants, which are no paths.
fn without_variants(tokens: TokenStream) -> TokenStream {
    let mut tokens: Vec<_> = tokens.into_iter().collect();
    if let Some(TokenTree::Group(body)) = tokens.pop() {
        let mut name = true;
        for token in body.stream() {
            match &token {
                TokenTree::Ident(_) if name => name = false,
                token => {
                    name |= is_punct(token, ',');
                    tokens.push(token.clone());
                }
            }
        }
    }
    tokens.into_iter().collect()
}

pub(crate) fn is_punct(token: &TokenTree, what: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == what)
}

/// Is this the body of `#[...]` that leaves code to tests only?
pub(crate) fn is_test_attribute(bracket: &proc_macro2::Group) -> bool {
    bracket.delimiter() == Delimiter::Bracket
        && syn::parse2::<Meta>(bracket.stream()).is_ok_and(|meta| is_test_meta(&meta))
}

fn is_test(attribute: &Attribute) -> bool {
    is_test_meta(&attribute.meta)
}

fn is_test_meta(meta: &Meta) -> bool {
    match meta {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("cfg") => {
            list.parse_args().is_ok_and(|condition| needs_test(&condition))
        }
        _ => false,
    }
}

/// Does a condition hold in tests only?
fn needs_test(condition: &Meta) -> bool {
    let parts = |list: &syn::MetaList| {
        list.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated).unwrap_or_default().into_iter()
    };
    match condition {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("all") => parts(list).any(|part| needs_test(&part)),
        Meta::List(list) if list.path.is_ident("any") => parts(list).all(|part| needs_test(&part)),
        _ => false,
    }
}

fn doc_line(attribute: &Attribute) -> Option<String> {
    match &attribute.meta {
        Meta::NameValue(meta) if meta.path.is_ident("doc") => match &meta.value {
            syn::Expr::Lit(syn::ExprLit { lit: syn::Lit::Str(line), .. }) => Some(line.value()),
            _ => None,
        },
        _ => None,
    }
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}
