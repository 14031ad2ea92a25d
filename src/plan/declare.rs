//! How an effect declares its passes: each stands in one place, with everything that is known of it before a frame is.

use super::{Binding, Pass, PassId, Resource};

/// Collects passes as they are declared. What their shaders bind, they bind by name.
#[derive(Debug)]
pub struct Declare {
    /// By [`PassId`].
    pub list: Vec<Pass>,
    resource: fn(&Binding) -> Option<Resource>,
}

impl Declare {
    /// `resource`: what a binding stands for.
    pub fn new(resource: fn(&Binding) -> Option<Resource>) -> Declare {
        Declare { list: Vec::new(), resource }
    }

    /// Adds a pass, or several.
    pub fn add<D: Declared>(&mut self, declared: D) -> D::Ids {
        declared.add_to(self)
    }
}

/// A pass, or several that are of a kind.
pub trait Declared {
    /// Their ids.
    type Ids;

    /// Adds them to the list.
    fn add_to(self, declare: &mut Declare) -> Self::Ids;
}

impl Declared for Pass {
    type Ids = PassId;

    fn add_to(self, declare: &mut Declare) -> PassId {
        declare.list.push(self.bind_all(declare.resource));
        PassId(declare.list.len() as u16 - 1)
    }
}

impl<const N: usize> Declared for [Pass; N] {
    type Ids = [PassId; N];

    fn add_to(self, declare: &mut Declare) -> [PassId; N] {
        self.map(|pass| pass.add_to(declare))
    }
}

impl Declared for Option<Pass> {
    type Ids = Option<PassId>;

    fn add_to(self, declare: &mut Declare) -> Option<PassId> {
        self.map(|pass| pass.add_to(declare))
    }
}

impl<D: Declared> Declared for Vec<D> {
    type Ids = Vec<D::Ids>;

    fn add_to(self, declare: &mut Declare) -> Vec<D::Ids> {
        self.into_iter().map(|some| some.add_to(declare)).collect()
    }
}

/// Declares the passes of an effect, `name = pass;` each, as the fields of `Passes`: a [`PassId`], or what is said.
macro_rules! passes {
    (
        ($($argument:ident: $type:ty),*), $resource:path;
        $($(#[$doc:meta])* $name:ident $(: $ids:ty)? = $pass:expr;)*
    ) => {
        /// The effect's declared passes, and which is which.
        #[derive(Debug)]
        pub struct Passes {
            /// By [`PassId`].
            pub list: Vec<Pass>,
            $($(#[$doc])* pub(super) $name: $crate::plan::passes!(@ids $($ids)?),)*
        }

        impl Passes {
            /// Declares every pass that some frame of this effect may need.
            pub fn new($($argument: $type),*) -> Passes {
                let mut declare = $crate::plan::Declare::new($resource);
                Passes { $($name: declare.add($pass),)* list: declare.list }
            }
        }
    };
    (@ids) => { $crate::plan::PassId };
    (@ids $ids:ty) => { $ids };
}
pub(crate) use passes;
