//! Where the faults are in the syntax tree, and what they are replaced by.

use std::collections::HashMap;
use std::ops::Range;

use proc_macro2::LineColumn;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Arm, BinOp, Block, Expr, ExprBinary, ExprStruct, ExprUnary, FieldValue, UnOp};

use crate::by_hand::ACTIVE;
use crate::text::{Piece, Site};

/// One line of the list.
pub struct Fault {
    id: usize,
    genre: String,
    start: (usize, usize),
    replacement: String,
}

impl Fault {
    pub fn read(id: usize, entry: &serde_json::Value) -> Option<Fault> {
        let start = &entry["span"]["start"];
        let place = |key: &str| usize::try_from(start[key].as_u64()?).ok();
        Some(Fault {
            id,
            genre: entry["genre"].as_str()?.to_owned(),
            start: (place("line")?, place("column")?),
            replacement: entry["replacement"].as_str()?.to_owned(),
        })
    }
}

/// The sites of `faults` in `source`, and the faults that found none.
pub fn find(source: &str, faults: Vec<Fault>) -> syn::Result<(Vec<Site>, Vec<usize>)> {
    let file = syn::parse_file(source)?;
    let mut line_starts = vec![0];
    line_starts.extend(source.match_indices('\n').map(|(at, _)| at + 1));
    let mut finder = Finder {
        source,
        line_starts,
        faults: HashMap::new(),
        sites: Vec::new(),
    };
    for fault in faults {
        let at = finder.faults.entry((kind(&fault.genre), fault.start));
        at.or_default().push(fault);
    }
    finder.visit_file(&file);
    let mut unplaced: Vec<usize> = finder
        .faults
        .into_values()
        .flatten()
        .map(|f| f.id)
        .collect();
    unplaced.sort();
    Ok((finder.sites, unplaced))
}

/// Faults of one kind share a place with no other.
fn kind(genre: &str) -> Kind {
    match genre {
        "FnValue" => Kind::Body,
        "BinaryOperator" | "UnaryOperator" => Kind::Operator,
        "MatchArm" => Kind::Arm,
        "MatchArmGuard" => Kind::Guard,
        _ => Kind::Field,
    }
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Kind {
    Body,
    Operator,
    Arm,
    Guard,
    Field,
}

struct Finder<'a> {
    source: &'a str,
    line_starts: Vec<usize>,
    faults: HashMap<(Kind, (usize, usize)), Vec<Fault>>,
    sites: Vec<Site>,
}

impl Finder<'_> {
    fn offset(&self, at: LineColumn) -> usize {
        let start = self.line_starts[at.line - 1];
        let line = &self.source[start..];
        start
            + line
                .char_indices()
                .nth(at.column)
                .map_or(line.len(), |(offset, _)| offset)
    }

    fn range(&self, node: &impl Spanned) -> Range<usize> {
        let span = node.span();
        self.offset(span.start())..self.offset(span.end())
    }

    fn take(&mut self, kind: Kind, node: &impl Spanned) -> Vec<Fault> {
        let start = node.span().start();
        self.faults
            .remove(&(kind, (start.line, start.column + 1)))
            .unwrap_or_default()
    }

    fn put(&mut self, old: Range<usize>, faults: &[Fault], pieces: Vec<Piece>) {
        let faults = faults.iter().map(|fault| fault.id).collect();
        self.sites.push(Site {
            old,
            pieces,
            faults,
        });
    }

    /// `match active { id => fault, …, _ => right }` with `form` of the operator in each arm.
    fn arms(faults: &[Fault], operator: &str, form: impl Fn(&str) -> Vec<Piece>) -> Vec<Piece> {
        let mut pieces = vec![new(format!("match {ACTIVE} {{"))];
        for fault in faults {
            let mut arm = vec![new(format!("{} => {{ ", fault.id))];
            arm.extend(form(&fault.replacement));
            arm.push(new(" }".into()));
            pieces.push(Piece::Arm(fault.id, arm));
        }
        pieces.push(new("_ => { ".into()));
        pieces.extend(form(operator));
        pieces.push(new(" } }".into()));
        pieces
    }

    fn binary(&mut self, node: &ExprBinary) {
        let faults = self.take(Kind::Operator, &node.op);
        if faults.is_empty() {
            return;
        }
        let (left, right) = (self.range(&node.left), self.range(&node.right));
        let operator = self.source[self.range(&node.op)].to_owned();
        let mut pieces;
        match node.op {
            // Both sides may end the evaluation early: x || y is !(!x && !y).
            BinOp::And(_) | BinOp::Or(_) => {
                let id = faults[0].id;
                let flip = format!("({ACTIVE} == {id})");
                pieces = vec![Piece::Arm(
                    id,
                    vec![
                        new(format!("({flip} ^ (({flip} ^ (")),
                        Piece::Old(left),
                        new(format!(")) {operator} ({flip} ^ (")),
                        Piece::Old(right),
                        new("))))".into()),
                    ],
                )];
            }
            BinOp::Eq(_)
            | BinOp::Ne(_)
            | BinOp::Lt(_)
            | BinOp::Le(_)
            | BinOp::Gt(_)
            | BinOp::Ge(_) => {
                pieces = vec![
                    new("(match (&(".into()),
                    Piece::Old(left),
                    new("), &(".into()),
                    Piece::Old(right),
                    new(")) { (left__, right__) => ".into()),
                ];
                pieces.extend(Self::arms(&faults, &operator, |operator| {
                    vec![new(format!("*left__ {operator} *right__"))]
                }));
                pieces.push(new(" })".into()));
            }
            BinOp::Add(_)
            | BinOp::Sub(_)
            | BinOp::Mul(_)
            | BinOp::Div(_)
            | BinOp::Rem(_)
            | BinOp::BitXor(_)
            | BinOp::BitAnd(_)
            | BinOp::BitOr(_)
            | BinOp::Shl(_)
            | BinOp::Shr(_) => {
                pieces = vec![
                    new("(match (".into()),
                    Piece::Old(left),
                    new(", ".into()),
                    Piece::Old(right),
                    new(") { (left__, right__) => ".into()),
                ];
                pieces.extend(Self::arms(&faults, &operator, |operator| {
                    vec![new(format!("left__ {operator} right__"))]
                }));
                pieces.push(new(" })".into()));
            }
            _ => {
                pieces = vec![
                    new("{ match ".into()),
                    Piece::Old(right),
                    new(" { right__ => ".into()),
                ];
                pieces.extend(Self::arms(&faults, &operator, |operator| {
                    vec![
                        Piece::Old(left.clone()),
                        new(format!(" {operator} right__")),
                    ]
                }));
                pieces.push(new(" } }".into()));
            }
        }
        self.put(self.range(node), &faults, pieces);
    }
}

fn new(text: String) -> Piece {
    Piece::New(text)
}

/// Whether `&&` chains a `let`.
fn chains_let(expression: &Expr) -> bool {
    match expression {
        Expr::Let(_) => true,
        Expr::Binary(node) => chains_let(&node.left) || chains_let(&node.right),
        _ => false,
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_expr_binary(&mut self, node: &'ast ExprBinary) {
        if !chains_let(&node.left) && !chains_let(&node.right) {
            self.binary(node);
        }
        visit::visit_expr_binary(self, node);
    }

    fn visit_expr_unary(&mut self, node: &'ast ExprUnary) {
        let operator = match node.op {
            UnOp::Neg(_) => "-",
            UnOp::Not(_) => "!",
            _ => return visit::visit_expr_unary(self, node),
        };
        let faults = self.take(Kind::Operator, &node.op);
        if !faults.is_empty() {
            let mut pieces = vec![
                new("(match ".into()),
                Piece::Old(self.range(&node.expr)),
                new(" { only__ => ".into()),
            ];
            pieces.extend(Self::arms(&faults, operator, |operator| {
                vec![new(format!("{operator}only__"))]
            }));
            pieces.push(new(" })".into()));
            self.put(self.range(node), &faults, pieces);
        }
        visit::visit_expr_unary(self, node);
    }

    fn visit_block(&mut self, node: &'ast Block) {
        if let Some(first) = node.stmts.first() {
            let faults = self.take(Kind::Body, first);
            if !faults.is_empty() {
                let start = self.offset(first.span().start());
                let line = |fault: &Fault| {
                    let (id, value) = (fault.id, &fault.replacement);
                    let text = format!("if {ACTIVE} == {id} {{ return {value}; }}");
                    Piece::Arm(id, vec![new(text)])
                };
                let pieces = faults.iter().map(line).collect();
                self.put(start..start, &faults, pieces);
            }
        }
        visit::visit_block(self, node);
    }

    fn visit_arm(&mut self, node: &'ast Arm) {
        let removed = self.take(Kind::Arm, node);
        if let Some((_, guard)) = &node.guard {
            let faults = self.take(Kind::Guard, &**guard);
            if !faults.is_empty() {
                let range = self.range(&**guard);
                let mut pieces = vec![new(format!("match {ACTIVE} {{"))];
                for fault in faults.iter().chain(&removed) {
                    let value = if fault.replacement == "true" {
                        "true"
                    } else {
                        "false"
                    };
                    let text = format!("{} => {value},", fault.id);
                    pieces.push(Piece::Arm(fault.id, vec![new(text)]));
                }
                pieces.extend([
                    new("_ => ".into()),
                    Piece::Old(range.clone()),
                    new(" }".into()),
                ]);
                self.put(range, &faults, pieces);
            }
        } else if let Some(fault) = removed.first() {
            let end = self.offset(node.pat.span().end());
            let text = format!(" if {ACTIVE} != {}", fault.id);
            self.put(
                end..end,
                &removed,
                vec![Piece::Arm(fault.id, vec![new(text)])],
            );
        }
        visit::visit_arm(self, node);
    }

    fn visit_expr_struct(&mut self, node: &'ast ExprStruct) {
        if let Some(base) = &node.rest {
            for field in &node.fields {
                self.field(field, base);
            }
        }
        visit::visit_expr_struct(self, node);
    }
}

impl Finder<'_> {
    fn field(&mut self, field: &FieldValue, base: &Expr) {
        let faults = self.take(Kind::Field, field);
        let (Some(fault), syn::Member::Named(name)) = (faults.first(), &field.member) else {
            return;
        };
        let value = match field.colon_token {
            Some(_) => Piece::Old(self.range(&field.expr)),
            None => new(name.to_string()),
        };
        let base = self.source[self.range(base)].to_owned();
        let text = format!(
            "{name}: if {ACTIVE} == {} {{ ({base}).{name} }} else {{ ",
            fault.id
        );
        let pieces = vec![Piece::Arm(
            fault.id,
            vec![new(text), value, new(" }".into())],
        )];
        self.put(self.range(field), &faults, pieces);
    }
}
