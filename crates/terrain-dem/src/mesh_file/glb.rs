//! Binary glTF 2.0: a header, a chunk of JSON that says what the bytes are, and a chunk of bytes: positions, normals and
//! indices, one after the other (Khronos, glTF 2.0 specification, section 4).

use std::io::{self, Write};

use super::{Mesh, too_large};

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;

pub fn write(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let bytes = [size_of_val(&mesh.positions_m[..]), size_of_val(&mesh.normals[..]), size_of_val(&mesh.triangles[..])];
    let binary: usize = bytes.iter().sum();
    let mut json = json(mesh, bytes);
    json += &" ".repeat(json.len().next_multiple_of(4) - json.len());
    // The header and the heads of both chunks.
    let all = 12 + 8 + json.len() + 8 + binary;
    let length = |bytes: usize| u32::try_from(bytes).map_err(|_| too_large("more than 4 GiB of glTF"));
    out.write_all(MAGIC)?;
    out.write_all(&VERSION.to_le_bytes())?;
    out.write_all(&length(all)?.to_le_bytes())?;
    out.write_all(&length(json.len())?.to_le_bytes())?;
    out.write_all(b"JSON")?;
    out.write_all(json.as_bytes())?;
    out.write_all(&length(binary)?.to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    for number in mesh.positions_m.as_flattened().iter().chain(mesh.normals.as_flattened()) {
        out.write_all(&number.to_le_bytes())?;
    }
    mesh.triangles.as_flattened().iter().try_for_each(|index| out.write_all(&index.to_le_bytes()))
}

/// What the bytes are. Buffer views and accessors are numbered in the order of the bytes.
fn json(mesh: &Mesh, [positions, normals, triangles]: [usize; 3]) -> String {
    let (vertices, indices) = (mesh.positions_m.len(), 3 * mesh.triangles.len());
    let bound = |pick: fn(f32, f32) -> f32| {
        let over = |axis: usize| mesh.positions_m.iter().map(|p| p[axis]).reduce(pick).unwrap_or(0.0);
        format!("[{},{},{}]", over(0), over(1), over(2))
    };
    let (low, high) = (bound(f32::min), bound(f32::max));
    const FLOAT: u32 = 5126;
    const UNSIGNED_INT: u32 = 5125;
    const ARRAY_BUFFER: u32 = 34962;
    const ELEMENT_ARRAY_BUFFER: u32 = 34963;
    let view = |offset: usize, length: usize, target: u32| {
        format!(r#"{{"buffer":0,"byteOffset":{offset},"byteLength":{length},"target":{target}}}"#)
    };
    let views = [
        view(0, positions, ARRAY_BUFFER),
        view(positions, normals, ARRAY_BUFFER),
        view(positions + normals, triangles, ELEMENT_ARRAY_BUFFER),
    ];
    let accessor = |view: u32, component: u32, count: usize, kind: &str, range: &str| {
        format!(r#"{{"bufferView":{view},"componentType":{component},"count":{count},"type":"{kind}"{range}}}"#)
    };
    let accessors = [
        accessor(0, FLOAT, vertices, "VEC3", &format!(r#","min":{low},"max":{high}"#)),
        accessor(1, FLOAT, vertices, "VEC3", ""),
        accessor(2, UNSIGNED_INT, indices, "SCALAR", ""),
    ];
    format!(
        r#"{{"asset":{{"version":"2.0","generator":"terrain-lod"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1}},"indices":2}}]}}],"buffers":[{{"byteLength":{}}}],"bufferViews":[{}],"accessors":[{}]}}"#,
        positions + normals + triangles,
        views.join(","),
        accessors.join(","),
    )
}

#[cfg(test)]
mod tests {
    use crate::mesh_file::MeshFormat;
    use crate::mesh_file::tests::{POSITIONS, TRIANGLES, written};

    #[test]
    fn chunks_are_as_long_as_they_say_and_bytes_where_the_json_says() {
        let file = written(MeshFormat::Glb);
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
        let json_length = word(12);
        assert_eq!((&file[16..20], json_length % 4), (&b"JSON"[..], 0));
        let json = std::str::from_utf8(&file[20..20 + json_length]).unwrap();
        assert!(json.contains(r#""min":[0,-2,0],"max":[10.5,1,10]"#), "{json}");
        assert!(json.contains(r#"{"buffer":0,"byteOffset":96,"byteLength":24,"target":34963}"#), "{json}");
        let binary = 20 + json_length + 8;
        assert_eq!((word(binary - 8), &file[binary - 4..binary]), (96 + 24, &b"BIN\0"[..]));
        assert_eq!(file.len(), binary + 120);
        assert_eq!(file[binary + 24..binary + 28], POSITIONS[2][0].to_le_bytes());
        assert_eq!(file[binary + 96 + 12..binary + 100 + 12], TRIANGLES[1][0].to_le_bytes());
    }
}
