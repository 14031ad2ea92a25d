//! How often a walk meets the blocks of a loop.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// More steps than any walk through a kernel's loop may take.
pub const MOST_STEPS: usize = 1 << 20;

const SWITCH: u32 = 251;
const LOOP_MERGE: u32 = 246;
const LABEL: u32 = 248;
const BRANCH: u32 = 249;
const BRANCH_CONDITIONAL: u32 = 250;

/// A shader's blocks by their labels, with those that may follow, and the ends of its loops by their heads.
#[derive(Default)]
struct Graph {
    following: BTreeMap<u32, Vec<u32>>,
    loops: Vec<[u32; 2]>,
}

/// The instructions of a module after its header: opcode and operands.
fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words.get(5..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let (instruction, after) = rest.split_at_checked((first >> 16) as usize)?;
        rest = after;
        Some((first & 0xffff, instruction.get(1..)?))
    })
}

impl Graph {
    fn new(words: &[u32]) -> Graph {
        let (mut graph, mut block) = (Graph::default(), 0);
        for (opcode, operands) in instructions(words) {
            let following = match opcode {
                LABEL => {
                    block = operands[0];
                    continue;
                }
                LOOP_MERGE => {
                    graph.loops.push([block, operands[0]]);
                    continue;
                }
                BRANCH => vec![operands[0]],
                BRANCH_CONDITIONAL => operands[1..3].to_vec(),
                // The default, then pairs of a value and a label.
                SWITCH => operands[1..].iter().step_by(2).copied().collect(),
                _ => continue,
            };
            graph.following.insert(block, following);
        }
        graph
    }

    /// Steps from a block through all that follows but one; a block that is met again before it has been left counts again.
    fn steps(&self, [from, end]: [u32; 2]) -> usize {
        let (mut left, mut waiting, mut steps) = (BTreeSet::from([end]), VecDeque::from([from]), 0);
        while let Some(block) = waiting.pop_front().filter(|_| steps < MOST_STEPS) {
            steps += 1;
            let following = self.following.get(&block).into_iter().flatten();
            waiting.extend(following.filter(|next| !left.contains(next)));
            left.insert(block);
        }
        steps
    }
}

/// The most steps that any loop of a module takes, up to [`MOST_STEPS`].
pub fn most_steps(words: &[u32]) -> usize {
    let graph = Graph::new(words);
    graph.loops.iter().map(|ends| graph.steps(*ends)).max().unwrap_or(0)
}

#[test]
fn a_walk_doubles_with_each_branch() {
    // A loop's head, so many branches one after the other, each with two blocks that meet in the next, and the end.
    let doubled = |branches: u32| {
        let mut words = vec![0; 5];
        let mut add = |opcode: u32, operands: &[u32]| {
            words.push((operands.len() as u32 + 1) << 16 | opcode);
            words.extend(operands);
        };
        add(LABEL, &[1]);
        add(LOOP_MERGE, &[2, 1]);
        add(BRANCH, &[10]);
        for branch in 0..branches {
            let at = 10 * (branch + 1);
            add(LABEL, &[at]);
            add(BRANCH_CONDITIONAL, &[0, at + 1, at + 2]);
            for side in [at + 1, at + 2] {
                add(LABEL, &[side]);
                add(BRANCH, &[at + 10]);
            }
        }
        most_steps(&words)
    };
    assert!(doubled(5) > 2 * doubled(4) && doubled(8) < 1024 && doubled(24) == MOST_STEPS);
}
