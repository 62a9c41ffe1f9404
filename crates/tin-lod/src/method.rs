//! The method as the renderer sees it: a static vertex buffer, and for each patch or group a room
//! in the index buffer.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use terrain_core::{
    Aabb, BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Growth, Heightmap, IndexFormat, LodMethod, PatchTag,
    StageTime, VertexKind, View,
};

use crate::cull::PatchTree;
use crate::index_store::Rooms;
use crate::levels::Boxes;
use crate::mesh::{Mesh, SelectedFor, Update};
use crate::node_maps::NodeMaps;
use crate::nodes::{NodeId, Nodes, Owners};
use crate::options::{IndexStore, Options, Schedule, Selector, TinError};
use crate::patches::PatchId;
use crate::vertices::VertexStrips;
use crate::worker::{HandOver, Worker, Workshop};

/// View-dependent irregular mesh over a DEM in memory.
pub struct Tin {
    heightmap: Arc<Heightmap>,
    options: Options,
    culling: bool,
    nodes: Nodes,
    boxes: Arc<Boxes>,
    tree: Arc<PatchTree>,
    strips: VertexStrips,
    rooms: Rooms,
    /// Of each node what its triangles in the buffer were selected for.
    drawn_for: Vec<SelectedFor>,
    /// The nodes that are drawn: those of the updates that the plans have drawn so far.
    owners: Owners,
    updates: Updates,
    /// What the first plan uploads beside the vertices.
    coarsest: Option<Update>,
    /// The patches in view, and the nodes that they lie in: kept for their memory.
    visible: Vec<PatchId>,
    visible_nodes: Vec<NodeId>,
    /// The 2-byte indices of one node, kept for its memory.
    narrow: Vec<u16>,
}

/// Each update as it is, and at once.
const HAND_OVER: HandOver = |update, pass_on| pass_on(update);

/// Who updates the mesh.
enum Updates {
    /// Each plan does, and waits.
    InPlan { mesh: Mesh, pool: rayon::ThreadPool },
    /// The worker does.
    Behind(Worker),
}

impl Tin {
    /// Prepares the patches and groups of a DEM and its coarsest mesh.
    pub fn new(heightmap: Arc<Heightmap>, options: Options) -> Result<Self, TinError> {
        Self::with(heightmap, options, None, HAND_OVER)
    }

    /// As [`Tin::new`], with threshold maps that were computed before, of the same DEM and the options' patches and
    /// groups. [`Selector::Algorithm1`](crate::Selector::Algorithm1) needs none.
    pub fn with_maps(heightmap: Arc<Heightmap>, options: Options, maps: Arc<NodeMaps>) -> Result<Self, TinError> {
        Self::with(heightmap, options, Some(maps), HAND_OVER)
    }

    /// `hand_over`: how the worker hands its updates over.
    pub(crate) fn with(
        heightmap: Arc<Heightmap>,
        options: Options,
        maps: Option<Arc<NodeMaps>>,
        hand_over: HandOver,
    ) -> Result<Self, TinError> {
        options.validate()?;
        let nodes = Nodes::new(&heightmap, options.patch, options.group());
        if maps.as_ref().is_some_and(|maps| *maps.nodes() != nodes) {
            return Err(TinError::Maps);
        }
        check_size(&heightmap, &nodes, &options)?;
        let fault =
            |error: &dyn std::fmt::Display| TinError::Threads { threads: options.threads, reason: error.to_string() };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(options.threads)
            .thread_name(|i| format!("tin-lod {i}"))
            .build()
            .map_err(|error| fault(&error))?;
        let with_blocks = options.blocks && options.selector == Selector::Bounded;
        let boxes = Arc::new(pool.install(|| Boxes::new(&heightmap, &nodes, with_blocks)));
        let (mesh, coarsest) = pool.install(|| Mesh::coarsest(&heightmap, &options, &nodes, boxes.clone(), maps));
        let bounds_world: Vec<Aabb> = (0..nodes.patches().patches()).map(|p| *boxes.of(p)).collect();
        let tree = Arc::new(PatchTree::new(nodes.patches(), bounds_world));
        let updates = match options.schedule {
            Schedule::Blocking => Updates::InPlan { mesh, pool },
            Schedule::Live => {
                let (heightmap, tree) = (heightmap.clone(), tree.clone());
                let workshop = Workshop { heightmap, options, pool, tree, mesh, hand_over };
                let worker = Worker::start(workshop).map_err(|error| fault(&error))?;
                Updates::Behind(worker)
            }
        };
        Ok(Self {
            strips: options.vertex_strips(&heightmap),
            rooms: rooms(&nodes, &options),
            drawn_for: vec![SelectedFor::ToleranceM(f64::INFINITY); nodes.len()],
            heightmap,
            options,
            culling: true,
            owners: Owners::roots(&nodes),
            nodes,
            boxes,
            tree,
            updates,
            coarsest: Some(coarsest),
            visible: Vec::new(),
            visible_nodes: Vec::new(),
            narrow: Vec::new(),
        })
    }

    /// Once: the DEM's vertices, and the coarsest mesh.
    fn initialise(&mut self, plan: &mut FramePlan) {
        if let Some(coarsest) = self.coarsest.take() {
            plan.upload(Buffer::Vertices, 0, &self.strips.fill(&self.heightmap));
            self.map_to_buffers(coarsest, plan);
        }
    }

    fn update(&mut self, view: &View, plan: &mut FramePlan) {
        let updates: Vec<Update> = match &mut self.updates {
            Updates::InPlan { mesh, pool } => {
                let outdated = mesh.outdated(&self.options, view, &self.visible);
                let update = || mesh.update(&self.heightmap, &self.options, view, &outdated);
                (!outdated.is_empty()).then(|| pool.install(update)).into_iter().collect()
            }
            Updates::Behind(worker) => {
                worker.show(view, self.culling);
                worker.finished()
            }
        };
        updates.into_iter().for_each(|update| self.map_to_buffers(update, plan));
    }

    /// The last step of Algorithm 2: the triangles of each node into the node's room. Smoothed vertices with them.
    fn map_to_buffers(&mut self, update: Update, plan: &mut FramePlan) {
        for node in update.retired {
            self.rooms.place(node, 0);
        }
        for made in update.triangulated {
            self.owners.give(&self.nodes, made.node);
            self.drawn_for[made.node as usize] = made.selected_for;
            if let Some(indices) = made.indices {
                self.upload(made.node, &indices, plan);
            }
        }
        for run in update.vertices {
            let first = self.strips.inner_vertex(run.first) as u64;
            plan.upload(Buffer::Vertices, first * size_of::<BakedVertex>() as u64, &run.vertices);
        }
        plan.work.push(update.report);
    }

    fn upload(&mut self, node: NodeId, indices: &[u32], plan: &mut FramePlan) {
        let first = self.rooms.place(node, indices.len() as u32).start as u64;
        match self.index_format() {
            IndexFormat::U32 => plan.upload(Buffer::Indices, first * 4, indices),
            IndexFormat::U16 => {
                self.narrow.clear();
                self.narrow.extend(indices.iter().map(|index| *index as u16));
                if self.narrow.len() % 2 == 1 {
                    self.narrow.push(0); // Uploads are multiples of 4 bytes, and so are rooms.
                }
                plan.upload(Buffer::Indices, first * 2, &self.narrow);
            }
        }
    }

    /// A node has at most 65 x 65 samples, so strips make every index small.
    fn index_format(&self) -> IndexFormat {
        match self.options.index_store {
            IndexStore::Fixed => IndexFormat::U32,
            IndexStore::Packed => IndexFormat::U16,
        }
    }

    fn index_bytes(&self) -> u64 {
        self.rooms.capacity() as u64 * self.index_format().bytes()
    }

    fn draw(&self, node: NodeId) -> Draw {
        let (area, indices) = (self.nodes.area(node), self.rooms.of(node));
        // How many times the triangles would halve on the way from the fully refined node: for the pictures.
        let level = (6 * area.width * area.depth / indices.len() as u32).ilog2().min(15);
        Draw::baked(indices, self.strips.first_vertex(area) as i32, PatchTag { patch: node, level })
    }

    fn is_stale(&self, node: NodeId, view: &View) -> bool {
        self.drawn_for[node as usize].is_outdated(&self.boxes, node, &self.options, view)
    }
}

/// Vertices and indices are numbered in 32 bits, and what a draw adds to indices has a sign.
fn check_size(heightmap: &Heightmap, nodes: &Nodes, options: &Options) -> Result<(), TinError> {
    let vertices = options.vertex_strips(heightmap).vertices();
    let places = nodes.roots().map(|root| nodes.places(root).end).max().unwrap_or(0) as u64;
    let indices = match options.index_store {
        IndexStore::Fixed => places * indices_of_patch(options) as u64,
        IndexStore::Packed => 0,
    };
    let fits = vertices <= i32::MAX as u64 && indices <= u32::MAX as u64;
    if fits { Ok(()) } else { Err(TinError::Size { vertices, indices }) }
}

fn indices_of_patch(options: &Options) -> u32 {
    6 * options.patch * options.patch
}

/// Room for a fully refined node (the triangulation of all its samples has two triangles a quad), or by need.
fn rooms(nodes: &Nodes, options: &Options) -> Rooms {
    let of_patch = indices_of_patch(options);
    let fixed = |node| {
        let Range { start, end } = nodes.places(node);
        start * of_patch..end * of_patch
    };
    match options.index_store {
        IndexStore::Fixed => Rooms::fixed((0..nodes.len() as NodeId).map(fixed)),
        IndexStore::Packed => Rooms::packed(nodes.len()),
    }
}

impl LodMethod for Tin {
    fn name(&self) -> &'static str {
        "tin"
    }

    fn buffers(&self) -> BufferSizes {
        BufferSizes {
            vertex_kind: VertexKind::Baked,
            index_format: self.index_format(),
            vertices: self.strips.vertices() * size_of::<BakedVertex>() as u64,
            indices: self.index_bytes(),
            instances: 0,
            heights: None,
            cell_side: None,
        }
    }

    fn set_culling(&mut self, culling: bool) {
        self.culling = culling;
    }

    fn plan(&mut self, view: &View, plan: &mut FramePlan) {
        plan.clear();
        let index_bytes = self.index_bytes();
        self.initialise(plan);
        let start = Instant::now();
        self.tree.visible(view, self.culling, &mut self.visible);
        plan.cull = StageTime(start.elapsed());
        self.update(view, plan);
        if self.index_bytes() > index_bytes {
            plan.growths.push(Growth { buffer: Buffer::Indices, bytes: self.index_bytes() });
        }
        self.owners.of_all(self.visible.iter().copied(), &mut self.visible_nodes);
        let may_be_stale = matches!(self.updates, Updates::Behind(_));
        for node in &self.visible_nodes {
            let is_stale = may_be_stale && self.is_stale(*node, view);
            plan.stale_patches += u32::from(is_stale);
            let draw = self.draw(*node);
            plan.draws.push(if is_stale { draw.stale() } else { draw });
        }
    }
}
