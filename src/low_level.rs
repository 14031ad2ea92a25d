//! Parts of effects, for those who read back their buffers, run kernels of their own, or go through their plans.
//! Nothing here is promised to stay: all of it may change with any version.

/// Makes the public items of private modules public here.
macro_rules! modules {
    ($($(#[$attribute:meta])* $module:ident = $path:path;)+) => {
        $($(#[$attribute])* pub mod $module { pub use $path::*; })+
    };
}

modules! {
    /// Which barriers steps need.
    barrier = crate::barrier;
    /// Buffers, images, pipelines, command buffers.
    gpu = crate::gpu;
    /// Noise of the shaders, on the CPU.
    noise = crate::noise;
    /// Passes, and plans of them.
    plan = crate::plan;
    /// Prefix sums.
    scan = crate::scan;
    /// Hashes and random numbers of the shaders, on the CPU.
    random = crate::random;
    /// The output of build.rs for `glsl`: SPIR-V, its bindings, structures and constants.
    shaders = crate::shaders;
}

/// Of [`crate::smoke`].
pub mod smoke {
    modules! {
        /// Its buffers and images.
        layout = crate::smoke::layout;
        /// How much there may be of everything.
        limits = crate::smoke::limits;
        /// Parameters of its kernels.
        params = crate::smoke::params;
        /// Its passes.
        passes = crate::smoke::passes;
        /// How radii are searched.
        search = crate::smoke::search;
        /// Which passes a frame takes.
        steps = crate::smoke::steps;
        /// Tables that are computed once.
        tables = crate::smoke::tables;
    }
}

/// Of [`crate::flame`].
pub mod flame {
    modules! {
        /// Its buffers and images.
        layout = crate::flame::layout;
        /// How much there may be of everything.
        limits = crate::flame::limits;
        /// Parameters of its kernels.
        params = crate::flame::params;
        /// Its passes.
        passes = crate::flame::passes;
        /// Which passes a frame takes.
        steps = crate::flame::steps;
        /// Colours of temperatures.
        colour = crate::flame::colour;
    }
}

/// Of [`crate::blur`].
pub mod blur {
    modules! {
        /// Its buffers and images.
        layout = crate::blur::layout;
        /// How much there may be of everything.
        limits = crate::blur::limits;
        /// Parameters of its kernels.
        params = crate::blur::params;
        /// Its passes.
        passes = crate::blur::passes;
        /// Which passes a frame takes.
        steps = crate::blur::steps;
        /// Closed surfaces of its mesh.
        shells = crate::blur::shells;
    }
}
