//! The changes of a Rust file, and the file that contains all of them, each with a switch.
//!
//! ```text
//! a + b      (match ((a), (b)) { (l, r) => if on(7) { l - r } else { l + r } })
//! a && b     (match (a) { l => if l != on(8) { b } else { l } })
//! ```
//!
//! An operand is evaluated once and appears once, so that nested changes do not multiply. Expressions that must be
//! constant at compile time, and macros, are not changed.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, BinOp, Expr, Lit, ReturnType, Signature, Type, UnOp};

/// A change that can be switched on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The file, from the root.
    pub file: String,
    pub line: usize,
    /// Its column.
    pub column: usize,
    /// The function that it is in.
    pub function: String,
    /// What is replaced, and by what.
    pub what: String,
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { file, line, column, function, what } = self;
        write!(f, "{file}:{line}:{column} {function}: {what}")
    }
}

/// Order of insertions at one place: ends come before replacements and beginnings.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    End,
    Instead,
    Begin,
}

struct Edit {
    at: usize,
    removed: usize,
    side: Side,
    /// Index of the change among those of the file.
    change: usize,
    text: String,
}

impl Edit {
    /// At one place, the end of the innermost change comes first, and its beginning last.
    fn key(&self) -> (usize, Side, isize) {
        let order = self.change as isize;
        (self.at, self.side, if self.side == Side::End { -order } else { order })
    }
}

/// A file, and its changes in the order of the text.
pub struct Source {
    pub file: String,
    text: String,
    edits: Vec<Edit>,
    pub changes: Vec<Change>,
    functions: Vec<String>,
}

/// A file with switched changes: its text, and the place of each change.
pub struct Rewritten {
    pub text: String,
    /// Change and range of bytes.
    pub places: Vec<(usize, std::ops::Range<usize>)>,
}

impl Source {
    /// # Errors
    ///
    /// A text that is not Rust.
    pub fn read(file: &str, text: &str) -> syn::Result<Self> {
        let parsed = syn::parse_file(text)?;
        let (edits, changes, functions) = (Vec::new(), Vec::new(), Vec::new());
        let mut source =
            Self { file: file.to_owned(), text: text.to_owned(), edits, changes, functions };
        source.visit_file(&parsed);
        source.edits.sort_by_key(Edit::key);
        Ok(source)
    }

    /// The text with switches; `switch` gives the number of a change's switch, if it has one.
    pub fn rewrite(&self, switch: impl Fn(usize) -> Option<usize>) -> Rewritten {
        let (mut text, mut from) = (String::with_capacity(4 * self.text.len()), 0);
        let mut places: Vec<(usize, std::ops::Range<usize>)> = Vec::new();
        for edit in &self.edits {
            let Some(number) = switch(edit.change) else { continue };
            text.push_str(&self.text[from..edit.at]);
            from = edit.at + edit.removed;
            let start = text.len();
            text.push_str(&edit.text.replace("ON", &format!("crate::switch::on({number})")));
            match places.iter_mut().find(|(change, _)| *change == edit.change) {
                Some((_, range)) => range.end = text.len(),
                None => places.push((edit.change, start..text.len())),
            }
        }
        text.push_str(&self.text[from..]);
        Rewritten { text, places }
    }

    fn change(&mut self, at: Span, what: String) -> usize {
        let (file, function) = (self.file.clone(), self.functions.join("::"));
        let (line, column) = (at.start().line, at.start().column + 1);
        self.changes.push(Change { file, line, column, function, what });
        self.changes.len() - 1
    }

    fn edit(&mut self, change: usize, side: Side, at: usize, removed: usize, text: &str) {
        self.edits.push(Edit { at, removed, side, change, text: text.to_owned() });
    }

    /// Puts text before and after an expression.
    fn wrap(&mut self, change: usize, span: Span, before: &str, after: &str) {
        let range = span.byte_range();
        self.edit(change, Side::Begin, range.start, 0, before);
        self.edit(change, Side::End, range.end, 0, after);
    }

    /// Switches between two operators, whose operands are evaluated before, or borrowed.
    fn operator(&mut self, whole: &syn::ExprBinary, by: &str, borrowed: bool) {
        let op = whole.op.span();
        let name = op.source_text().unwrap_or_default();
        let change = self.change(op, format!("`{by}` for `{name}`"));
        let and = if borrowed { "&" } else { "" };
        let after = format!(")) {{ (l, r) => if ON {{ l {by} r }} else {{ l {name} r }} }})");
        self.wrap(change, whole.span(), &format!("(match ({and}("), &after);
        let range = op.byte_range();
        self.edit(change, Side::Instead, range.start, range.len(), &format!("), {and}("));
    }

    /// Switches between `&&` and `||`; the second operand stays lazy.
    fn connective(&mut self, whole: &syn::ExprBinary, by: &str, decided: &str) {
        let op = whole.op.span();
        let name = op.source_text().unwrap_or_default();
        let change = self.change(op, format!("`{by}` for `{name}`"));
        self.wrap(change, whole.span(), "(match (", "} else { l } })");
        let range = op.byte_range();
        let text = format!(") {{ l => if l {decided} ON {{");
        self.edit(change, Side::Instead, range.start, range.len(), &text);
    }

    /// Changes what is added to a variable, or multiplied with it.
    fn operand(&mut self, whole: &syn::ExprBinary, what: &str, by: &str) {
        let change = self.change(whole.op.span(), what.to_owned());
        let after = format!(") {{ r => if ON {{ {by} }} else {{ r }} }})");
        self.wrap(change, whole.right.span(), "(match (", &after);
    }

    fn binary(&mut self, whole: &syn::ExprBinary) {
        match whole.op {
            BinOp::Add(_) => self.operator(whole, "-", false),
            BinOp::Sub(_) => self.operator(whole, "+", false),
            BinOp::Mul(_) => self.operator(whole, "/", false),
            BinOp::Div(_) => self.operator(whole, "*", false),
            BinOp::Eq(_) => self.operator(whole, "!=", true),
            BinOp::Ne(_) => self.operator(whole, "==", true),
            BinOp::Lt(_) | BinOp::Le(_) => self.operator(whole, ">", true),
            BinOp::Gt(_) | BinOp::Ge(_) => self.operator(whole, "<", true),
            BinOp::And(_) if !has_let(whole) => self.connective(whole, "||", "!="),
            BinOp::Or(_) => self.connective(whole, "&&", "=="),
            BinOp::AddAssign(_) | BinOp::SubAssign(_) | BinOp::BitOrAssign(_) => {
                self.operand(whole, "nothing for what is added", "Default::default()");
            }
            BinOp::MulAssign(_) | BinOp::DivAssign(_) => {
                self.operand(whole, "twice the factor", "r + r");
            }
            _ => {}
        }
    }

    /// Returns at once with a value of the type, if one can be written down.
    fn returns(&mut self, signature: &Signature, block: &syn::Block) {
        let values: &[&str] = match &signature.output {
            ReturnType::Default => &["()"],
            ReturnType::Type(_, of) => match last_name(of).as_deref() {
                Some("bool") => &["true", "false"],
                Some("f64" | "usize" | "u64" | "Option") => &["Default::default()"],
                _ => &[],
            },
        };
        let at = block.brace_token.span.open().byte_range().end;
        for value in values {
            let change = self.change(signature.ident.span(), format!("returns `{value}`"));
            self.edit(change, Side::Begin, at, 0, &format!(" if ON {{ return {value}; }}"));
        }
    }

    /// A function that belongs to the engine, not to its tests.
    fn function<'a>(
        &mut self,
        attributes: &[Attribute],
        signature: &'a Signature,
        block: &'a syn::Block,
    ) {
        if signature.constness.is_some() || attributes.iter().any(of_tests) {
            return;
        }
        self.functions.push(signature.ident.to_string());
        self.returns(signature, block);
        visit::visit_block(self, block);
        self.functions.pop();
    }
}

impl<'a> Visit<'a> for Source {
    fn visit_item_fn(&mut self, item: &'a syn::ItemFn) {
        self.function(&item.attrs, &item.sig, &item.block);
    }

    fn visit_impl_item_fn(&mut self, item: &'a syn::ImplItemFn) {
        self.function(&item.attrs, &item.sig, &item.block);
    }

    fn visit_item_impl(&mut self, item: &'a syn::ItemImpl) {
        self.functions.push(last_name(&item.self_ty).unwrap_or_default());
        visit::visit_item_impl(self, item);
        self.functions.pop();
    }

    fn visit_item_mod(&mut self, item: &'a syn::ItemMod) {
        if !item.attrs.iter().any(of_tests) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_expr(&mut self, expression: &'a Expr) {
        match expression {
            Expr::Binary(whole) => self.binary(whole),
            Expr::Unary(whole) if matches!(whole.op, UnOp::Not(_) | UnOp::Neg(_)) => {
                let name = whole.op.span().source_text().unwrap_or_default();
                let change = self.change(whole.op.span(), format!("no `{name}`"));
                let after = format!(") {{ r => if ON {{ r }} else {{ {name} r }} }})");
                let range = whole.op.span().byte_range();
                self.edit(change, Side::Begin, range.start, range.len(), "(match (");
                self.edit(change, Side::End, whole.span().byte_range().end, 0, &after);
            }
            Expr::Lit(literal) => {
                if let Lit::Float(number) = &literal.lit
                    && number.base10_parse::<f64>().is_ok_and(|value| value != 0.0)
                {
                    let change = self.change(number.span(), format!("1.5 times `{number}`"));
                    self.wrap(change, number.span(), "(", " * if ON { 1.5 } else { 1.0 })");
                }
            }
            _ => {}
        }
        visit::visit_expr(self, expression);
    }

    fn visit_expr_repeat(&mut self, expression: &'a syn::ExprRepeat) {
        self.visit_expr(&expression.expr);
    }

    // Constants at compile time, and syntax that is not an expression.
    fn visit_item_const(&mut self, _: &'a syn::ItemConst) {}
    fn visit_impl_item_const(&mut self, _: &'a syn::ImplItemConst) {}
    fn visit_item_static(&mut self, _: &'a syn::ItemStatic) {}
    fn visit_item_enum(&mut self, _: &'a syn::ItemEnum) {}
    fn visit_expr_const(&mut self, _: &'a syn::ExprConst) {}
    fn visit_generic_argument(&mut self, _: &'a syn::GenericArgument) {}
    fn visit_type_array(&mut self, _: &'a syn::TypeArray) {}
    fn visit_attribute(&mut self, _: &'a Attribute) {}
    fn visit_pat(&mut self, _: &'a syn::Pat) {}
}

fn of_tests(attribute: &Attribute) -> bool {
    let words = attribute.meta.path().is_ident("cfg")
        && attribute.parse_args::<syn::Ident>().is_ok_and(|word| word == "test");
    words || attribute.meta.path().is_ident("test")
}

/// The last word of a type's path.
fn last_name(of: &Type) -> Option<String> {
    let Type::Path(path) = of else { return None };
    path.path.segments.last().map(|segment| segment.ident.to_string())
}

/// True if a condition contains `let`, which is not an expression.
fn has_let(whole: &syn::ExprBinary) -> bool {
    [&whole.left, &whole.right].into_iter().any(|side| match &**side {
        Expr::Let(_) => true,
        Expr::Binary(inner) => has_let(inner),
        _ => false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
        const N: usize = 2 + 1;\n\
        fn f(a: f64, b: &[f64; 2 + 1]) -> bool {\n\
            if let Some(c) = b.first() && a < 1.5 * c - -a { return !b.is_empty() || a == 2.5; }\n\
            let mut sum = [0.0; 1 + 1];\n\
            sum[0] += a;\n\
            matches!(a, 1.0..=2.0)\n\
        }\n\
        #[cfg(test)] mod tests { fn g() -> f64 { 1.0 + 1.0 } }\n";

    /// Each change is found once, in the order of the text from outside in. Constants, patterns, macros, tests and
    /// `let` conditions have none.
    #[test]
    fn what_can_be_switched_is_found() {
        let source = Source::read("f.rs", TEXT).expect("Rust");
        let what: Vec<_> = source.changes.iter().map(|change| change.what.as_str()).collect();
        let here =
            ["returns `true`", "returns `false`", "`>` for `<`", "`+` for `-`", "`/` for `*`"];
        let there = ["1.5 times `1.5`", "no `-`", "`&&` for `||`", "no `!`", "`!=` for `==`"];
        let last = ["1.5 times `2.5`", "nothing for what is added"];
        assert_eq!(what, [&here[..], &there, &last].concat());
        assert!(source.changes.iter().all(|change| change.function == "f"));
    }

    /// The text with all switches and with some is Rust; with none it is unchanged.
    #[test]
    fn what_is_written_is_rust() {
        let source = Source::read("f.rs", TEXT).expect("Rust");
        assert_eq!(source.rewrite(|_| None).text, TEXT);
        for parts in 1..4 {
            let written = source.rewrite(|change| (change % parts == 0).then_some(change));
            syn::parse_file(&written.text)
                .unwrap_or_else(|error| panic!("{error}: {}", written.text));
            for (change, range) in written.places {
                let (what, text) = (&source.changes[change].what, &written.text[range]);
                assert!(text.contains(&format!("on({change})")), "{what}: {text}");
            }
        }
    }
}
