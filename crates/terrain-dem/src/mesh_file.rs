//! Meshes for other programs: PLY, Wavefront OBJ, binary STL and binary glTF.
//!
//! All have the axes of the terrain: x east, y up, z south, in metres, triangles counter-clockwise seen from above. That
//! is right-handed with y up, as glTF wants it. STL has no vertices to share and so no normals but the triangles'.

mod glb;
mod obj;
mod ply;
mod stl;

use std::io::{self, Write};
use std::path::Path;

/// A mesh to write.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// World positions in metres.
    pub positions_m: Vec<[f32; 3]>,
    /// Unit normals, one a position.
    pub normals: Vec<[f32; 3]>,
    /// Indices into both.
    pub triangles: Vec<[u32; 3]>,
}

/// A file format for meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Binary PLY.
    Ply,
    /// Wavefront OBJ: text.
    Obj,
    /// Binary STL.
    Stl,
    /// Binary glTF 2.0.
    Glb,
}

impl MeshFormat {
    /// The endings of the files.
    pub const ENDINGS: &'static str = ".ply, .obj, .stl or .glb";

    /// By the ending of a file's name.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            "stl" => Some(Self::Stl),
            "glb" => Some(Self::Glb),
            _ => None,
        }
    }

    /// Writes a mesh. Wrap the file in [`write_atomically`](crate::write_atomically), which buffers.
    pub fn write(self, out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
        match self {
            Self::Ply => ply::write(out, mesh),
            Self::Obj => obj::write(out, mesh),
            Self::Stl => stl::write(out, mesh),
            Self::Glb => glb::write(out, mesh),
        }
    }
}

/// A format's 32-bit field cannot say so much.
fn too_large(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("{what}; expected a smaller mesh, or another format"))
}

#[cfg(test)]
mod tests {
    use super::*;

    pub const POSITIONS: [[f32; 3]; 4] = [[0.0, 1.0, 0.0], [0.0, 1.0, 10.0], [10.5, -2.0, 0.0], [10.5, 1.0, 10.0]];
    pub const TRIANGLES: [[u32; 3]; 2] = [[0, 1, 2], [2, 1, 3]];

    pub fn written(format: MeshFormat) -> Vec<u8> {
        let mut file = Vec::new();
        let normals = vec![[0.0, 1.0, 0.0]; 4];
        let mesh = Mesh { positions_m: POSITIONS.into(), normals, triangles: TRIANGLES.into() };
        format.write(&mut file, &mesh).unwrap();
        file
    }

    #[test]
    fn formats_go_by_the_ending() {
        let of = |name: &str| MeshFormat::of(Path::new(name));
        assert_eq!([of("a.ply"), of("b.c.GLB")], [Some(MeshFormat::Ply), Some(MeshFormat::Glb)]);
        assert_eq!([of("a"), of("a.gltf"), of(".ply")], [None; 3]);
    }
}
