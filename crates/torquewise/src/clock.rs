//! Times that steps of a fit take, where there is a clock.

/// A moment; all are one in WebAssembly, whose library has no clock.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment(#[cfg(not(target_family = "wasm"))] std::time::Instant);

impl Moment {
    pub(crate) fn now() -> Self {
        Self(
            #[cfg(not(target_family = "wasm"))]
            std::time::Instant::now(),
        )
    }

    /// Time since an earlier moment \[s\].
    #[cfg(not(target_family = "wasm"))]
    pub(crate) fn since(self, earlier: Self) -> f64 {
        self.0.duration_since(earlier.0).as_secs_f64()
    }

    #[cfg(target_family = "wasm")]
    pub(crate) fn since(self, _earlier: Self) -> f64 {
        0.0
    }
}
