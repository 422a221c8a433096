//! Undamped massless nodes eliminated from a network of springs.

use crate::model::{Element, Node};
use crate::system::System;

/// The springs between the coordinates with mass, after the massless ones are eliminated by
/// star–mesh steps: a node with springs k_i to its neighbours becomes springs k_i·k_j/Σk between
/// them, without any subtraction.
pub(crate) struct Condensed {
    pub(crate) massive: Vec<usize>,
    pub(crate) springs: Vec<Element>,
    eliminated: Vec<(usize, Vec<(Node, f64)>)>,
}

impl Condensed {
    pub(crate) fn of(system: &System) -> Condensed {
        let (massive, massless): (Vec<usize>, Vec<usize>) =
            (0..system.len()).partition(|i| system.masses()[*i] > 0.0);
        let positive = system
            .springs()
            .iter()
            .filter(|spring| spring.coefficient > 0.0);
        let mut springs: Vec<Element> = positive.copied().collect();
        let mut eliminated = Vec::new();
        for node in massless {
            let here = Node::Coordinate(node);
            let touches = |spring: &Element| spring.first == here || spring.second == here;
            let star: Vec<(Node, f64)> = springs
                .iter()
                .filter(|spring| touches(spring))
                .map(|spring| {
                    let other = if spring.first == here {
                        spring.second
                    } else {
                        spring.first
                    };
                    (other, spring.coefficient)
                })
                .collect();
            springs.retain(|spring| !touches(spring));
            let total: f64 = star.iter().map(|(_, k)| k).sum();
            for (at, &(first, k)) in star.iter().enumerate() {
                for &(second, other) in &star[at + 1..] {
                    if first != second {
                        springs.push(Element {
                            first,
                            second,
                            coefficient: k / total * other,
                        });
                    }
                }
            }
            eliminated.push((node, star));
        }
        Condensed {
            massive,
            springs,
            eliminated,
        }
    }

    /// For each coordinate its place among those with mass.
    pub(crate) fn columns(&self, coordinates: usize) -> Vec<Option<usize>> {
        let mut columns = vec![None; coordinates];
        for (place, &i) in self.massive.iter().enumerate() {
            columns[i] = Some(place);
        }
        columns
    }

    /// Gives the eliminated nodes their place between their neighbours.
    pub(crate) fn extend(&self, shape: &mut [f64]) {
        for (node, star) in self.eliminated.iter().rev() {
            let total: f64 = star.iter().map(|(_, k)| k).sum();
            let at = |node: &Node| node.coordinate().map_or(0.0, |i| shape[i]);
            shape[*node] = star.iter().map(|(other, k)| k / total * at(other)).sum();
        }
    }
}
