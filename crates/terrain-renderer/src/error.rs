//! What can go wrong between a plan and a picture.

/// Why a picture was not drawn. One line each: what was found, what was expected, what to do.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// A backend name that wgpu does not know.
    #[error("unknown graphics backend '{0}': expected vulkan, metal, dx12, gl or noop")]
    UnknownBackend(String),
    /// No adapter fits the choice.
    #[error("no {wanted} adapter among [{found}]: install a driver (a software one will do) or choose another")]
    NoAdapter {
        /// What was asked for.
        wanted: String,
        /// The adapters that are there.
        found: String,
    },
    /// The adapter was found but gives no device.
    #[error("the adapter gave no device: {0}; choose another adapter")]
    NoDevice(String),
    /// A DEM or a picture that is larger than the adapter's textures.
    #[error("{what} of {} x {}: this adapter's textures end at {limit}; use a smaller one", size[0], size[1])]
    TextureTooLarge {
        /// What does not fit.
        what: &'static str,
        /// Its width and height in texels.
        size: [u32; 2],
        /// The adapter's longest side in texels.
        limit: u32,
    },
    /// A buffer of a method that is larger than the adapter allows.
    #[error("{buffer} buffer of {bytes} bytes: this adapter allows {limit}; use a smaller DEM or another method")]
    BufferTooLarge {
        /// Which of the method's buffers.
        buffer: &'static str,
        /// Bytes that the method needs.
        bytes: u64,
        /// Bytes that the adapter allows.
        limit: u64,
    },
    /// A draw that reads indices or instances that its buffers do not have.
    #[error("draw {draw} ends beyond its {buffer} buffer of {bytes} bytes: the method's plan breaks the contract")]
    DrawBeyondBuffer {
        /// Position of the draw in the plan.
        draw: usize,
        /// The buffer that is too short.
        buffer: &'static str,
        /// Its size in bytes.
        bytes: u64,
    },
    /// A method that brings its heights along, on an adapter whose vertices cannot read them.
    #[error("adapter '{0}' gives vertices no storage buffers: choose another adapter or a method that needs none")]
    NoHeightTiles(String),
    /// Vertices that take their heights from the DEM, over a scene that has none.
    #[error("the DEM's heights are not on the GPU: use a method that brings its heights along")]
    NoHeights,
    /// A wireframe on an adapter that cannot draw lines.
    #[error("adapter '{0}' cannot draw a wireframe (polygon mode line): turn the wireframe off")]
    NoWireframe(String),
    /// A view for another picture size than the target's.
    #[error("view of {} x {} pixels on a target of {} x {}: make both alike", view_px[0], view_px[1], target_px[0], target_px[1])]
    ViewSize {
        /// Pixels of the view.
        view_px: [u32; 2],
        /// Pixels of the target.
        target_px: [u32; 2],
    },
    /// Whatever the driver or wgpu's validation reported during the frame.
    #[error("the GPU reported: {0}")]
    Gpu(String),
    /// The GPU did not finish in time.
    #[error("the GPU did not answer within {seconds} s: is it busy or hung? Try a smaller picture")]
    Timeout {
        /// How long was waited.
        seconds: u64,
    },
    /// A picture that could not be written.
    #[error("cannot write '{path}': {source}")]
    Png {
        /// Where to.
        path: String,
        /// Why not.
        source: image::ImageError,
    },
}
