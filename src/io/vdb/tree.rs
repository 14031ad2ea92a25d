//! The tree of a grid: bricks of 8^3 voxels, and tiles, larger cubes of one value.

use super::bytes::Bytes;
use super::codec::{Mask, Packing, Value};
use super::{Element, ReadError};

/// Voxels along a side of a brick, of what has bricks, and of what has those.
const BRICK: i32 = 8;
const INNER: i32 = 16 * BRICK;
const OUTER: i32 = 32 * INNER;
/// Voxels of a brick.
const VOXELS: usize = (BRICK * BRICK * BRICK) as usize;
/// Memory of tiles in bytes: so much in any case, and so often what the file has up to there. It unpacks to more than that
/// only where it is made to.
const MOST_TILES: usize = 1 << 26;
const TILES_A_BYTE: usize = 16;
/// No voxel has a coordinate that is this far from 0.
const MOST_COORDINATE: i32 = 1 << 30;

/// A cube of one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tile {
    begin: [i32; 3],
    side: i32,
    value: Value,
    is_active: bool,
}

/// A brick as the tree has it.
#[derive(Clone, Copy, Debug)]
struct Leaf<'f> {
    begin: [i32; 3],
    active: Mask<'f>,
}

/// Where a grid has values, and what they are but for those of bricks.
#[derive(Debug)]
pub struct Tree<'f> {
    packing: Packing,
    /// What there is where there is nothing.
    background: Value,
    /// Those that are active, or have another value than the background.
    tiles: Vec<Tile>,
    leaves: Vec<Leaf<'f>>,
    /// Where the values of leaves begin.
    voxels: Bytes<'f>,
}

/// A cube of values.
#[derive(Clone, Copy, Debug)]
pub struct Brick<'b> {
    /// Its first voxel.
    pub begin: [i32; 3],
    /// Voxels along its sides.
    pub side: i32,
    /// Its values: of all voxels, z running fastest, or the one of all; each has as many components as the grid.
    pub values: &'b [f32],
    /// All are active, none is, or these bits are.
    active: Active<'b>,
}

#[derive(Clone, Copy, Debug)]
enum Active<'b> {
    All(bool),
    These(Mask<'b>),
}

impl Brick<'_> {
    /// Whether all voxels have one value.
    pub fn is_uniform(&self) -> bool {
        matches!(self.active, Active::All(_))
    }

    /// For how many voxels each of its values stands.
    pub fn voxels_of_each(&self) -> u64 {
        if self.is_uniform() { (self.side as u64).pow(3) } else { 1 }
    }

    /// Whether the voxel of a number is active; of one value: whether all are.
    pub fn is_active(&self, voxel: usize) -> bool {
        match self.active {
            Active::All(are) => are,
            Active::These(mask) => mask.is_on(voxel),
        }
    }
}

/// A node that has others: so many along a side (as a power of two), each with so many voxels along a side.
#[derive(Clone, Copy)]
struct Level {
    power: usize,
    child: i32,
}

impl Level {
    const OUTER: Level = Level { power: 5, child: INNER };
    const INNER: Level = Level { power: 4, child: BRICK };

    fn count(self) -> usize {
        1 << (3 * self.power)
    }

    fn place(self, begin: [i32; 3], number: usize) -> [i32; 3] {
        let last = (1 << self.power) - 1;
        let at = [number >> (2 * self.power), number >> self.power & last, number & last];
        [0, 1, 2].map(|axis| begin[axis] + at[axis] as i32 * self.child)
    }
}

impl<'f> Tree<'f> {
    /// Reads it, without the values of bricks: these stand in `voxels`.
    pub(super) fn read(packing: Packing, bytes: &mut Bytes<'f>, voxels: Bytes<'f>) -> Result<Tree<'f>, ReadError> {
        let buffers: u32 = bytes.value("how many buffers a tree has")?;
        if buffers != 1 {
            return Err(bytes.fault(format!("a tree has {buffers} buffers"), "1"));
        }
        let background = packing.value(bytes, "the background")?;
        let (tiles, children): (u32, u32) = (bytes.value("tiles")?, bytes.value("children")?);
        let mut tree = Tree { packing, background, tiles: Vec::new(), leaves: Vec::new(), voxels };
        for _ in 0..tiles {
            let begin = origin(bytes)?;
            let value = packing.value(bytes, "a tile")?;
            let is_active = bytes.value::<u8>("a tile")? != 0;
            tree.add(Tile { begin, side: OUTER, value, is_active });
        }
        let mut values = Vec::new();
        for _ in 0..children {
            let begin = origin(bytes)?;
            tree.node(bytes, Level::OUTER, begin, &mut values)?;
        }
        Ok(tree)
    }

    fn add(&mut self, tile: Tile) {
        let bits = |value: Value| value.map(f32::to_bits);
        if tile.is_active || bits(tile.value) != bits(self.background) {
            self.tiles.push(tile);
        }
    }

    fn node(
        &mut self,
        bytes: &mut Bytes<'f>,
        level: Level,
        begin: [i32; 3],
        values: &mut Vec<f32>,
    ) -> Result<(), ReadError> {
        const WHAT: &str = "a node of a tree";
        let children = Mask(bytes.take(level.count() / 8, WHAT)?);
        let active = Mask(bytes.take(level.count() / 8, WHAT)?);
        let components = self.packing.element.components;
        // Earlier versions leave out the places of children.
        let is_whole = self.packing.version >= super::codec::NODE_MASKS;
        let count = if is_whole { level.count() } else { level.count() - children.count() };
        self.packing.values(bytes, active, count, self.background, values)?;
        if size_of_val(&self.tiles[..]) > MOST_TILES + TILES_A_BYTE * bytes.at() as usize {
            let why = format!("the tree has {} tiles up to here", self.tiles.len());
            return Err(bytes.fault(why, "as many as a file of this size has"));
        }
        let tiles = (0..level.count()).filter(|number| !children.is_on(*number));
        for (index, number) in tiles.enumerate() {
            let from = components * if is_whole { number } else { index };
            let mut value = [0.0; 3];
            value[..components].copy_from_slice(&values[from..from + components]);
            let (begin, is_active) = (level.place(begin, number), active.is_on(number));
            self.add(Tile { begin, side: level.child, value, is_active });
        }
        for number in children.on() {
            let begin = level.place(begin, number);
            if level.child == BRICK {
                self.leaves.push(Leaf { begin, active: Mask(bytes.take(VOXELS / 8, WHAT)?) });
            } else {
                self.node(bytes, Level::INNER, begin, values)?;
            }
        }
        Ok(())
    }

    /// What its voxels have.
    pub fn element(&self) -> Element {
        self.packing.element
    }

    /// What there is where there is nothing; the components that it has are the first.
    pub fn background(&self) -> [f32; 3] {
        self.background
    }

    /// A fault of the tree, at the byte where its voxels begin.
    pub fn fault(&self, why: impl ToString, expected: impl Into<String>) -> ReadError {
        self.voxels.fault(why, expected)
    }

    /// How many voxels are active.
    pub fn active(&self) -> u64 {
        let tiles = self.tiles.iter().filter(|tile| tile.is_active).map(|tile| (tile.side as u64).pow(3));
        let leaves = self.leaves.iter().map(|leaf| leaf.active.count() as u64);
        tiles.sum::<u64>() + leaves.sum::<u64>()
    }

    /// First and last active voxel along each axis; none if there is none.
    pub fn bounds(&self) -> Option<[[i32; 3]; 2]> {
        let mut bounds = [[i32::MAX; 3], [i32::MIN; 3]];
        let mut grow = |first: [i32; 3], last: [i32; 3]| {
            for axis in 0..3 {
                bounds[0][axis] = bounds[0][axis].min(first[axis]);
                bounds[1][axis] = bounds[1][axis].max(last[axis]);
            }
        };
        for tile in self.tiles.iter().filter(|tile| tile.is_active) {
            grow(tile.begin, tile.begin.map(|c| c + tile.side - 1));
        }
        for leaf in &self.leaves {
            let at = |voxel: usize| place_in_brick(leaf.begin, voxel);
            leaf.active.on().for_each(|voxel| grow(at(voxel), at(voxel)));
        }
        (bounds[0][0] <= bounds[1][0]).then_some(bounds)
    }

    /// All tiles that are not inactive background, then all bricks, which must have been loaded.
    ///
    /// # Errors
    /// What is damaged, with the byte.
    pub fn each(&self, mut with: impl FnMut(&Brick)) -> Result<(), ReadError> {
        let components = self.packing.element.components;
        for tile in &self.tiles {
            let Tile { begin, side, value, is_active } = tile;
            let active = Active::All(*is_active);
            with(&Brick { begin: *begin, side: *side, values: &value[..components], active });
        }
        let mut bytes = self.voxels;
        let mut values = Vec::with_capacity(VOXELS * components);
        for leaf in &self.leaves {
            let active = Mask(bytes.take(VOXELS / 8, "a brick")?);
            let mut more = 0;
            if self.packing.version < super::codec::NODE_MASKS {
                bytes.take(12, "a brick's place")?;
                more = bytes.value::<u8>("a brick's buffers")?.saturating_sub(1);
            }
            self.packing.values(&mut bytes, active, VOXELS, self.background, &mut values)?;
            with(&Brick { begin: leaf.begin, side: BRICK, values: &values, active: Active::These(active) });
            for _ in 0..more {
                self.packing.values(&mut bytes, active, VOXELS, self.background, &mut values)?;
            }
        }
        Ok(())
    }
}

/// Where the voxel of a number of a brick is.
pub(super) fn place_in_brick(begin: [i32; 3], voxel: usize) -> [i32; 3] {
    let at = [voxel >> 6, voxel >> 3 & 7, voxel & 7];
    [0, 1, 2].map(|axis| begin[axis] + at[axis] as i32)
}

/// Where a node of the root begins.
fn origin(bytes: &mut Bytes) -> Result<[i32; 3], ReadError> {
    let before = *bytes;
    let begin: [i32; 3] = bytes.value("a node's place")?;
    match begin.iter().all(|c| c % OUTER == 0 && (-MOST_COORDINATE..MOST_COORDINATE).contains(c)) {
        true => Ok(begin),
        false => {
            Err(before.fault(format!("a node begins at {begin:?}"), format!("multiples of {OUTER}, none beyond 2^30")))
        }
    }
}
