//! The index lists of one `k`, and the vertices that they index: `cargo run -p htp-lod --example index_lists -- 3`

use htp_lod::{index_list, local_vertices};

fn main() {
    let k = std::env::args().nth(1).map_or(3, |k| k.parse().expect("small triangles along a side"));
    println!("{} vertices, as steps to the left and to the right end:", local_vertices(k).len());
    println!("{:?}\n", local_vertices(k).iter().map(|vertex| vertex.uv).collect::<Vec<_>>());
    let names = ["plain", "hypotenuse", "left", "hypotenuse, left", "right", "hypotenuse, right", "left, right"];
    for (mask, collapsed) in (0..).zip(names) {
        let list = index_list(k, mask);
        println!("mask {mask} ({collapsed}): {} triangles {list:?}", list.len());
    }
}
