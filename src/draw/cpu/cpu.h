// SPDX-License-Identifier: MIT
//
// The CPU backend. A frame prepares the items (matrices, data, textures), and draws them in tasks
// into one visibility buffer per worker. Then it processes the picture in bands: merges the
// workers' buffers to the nearest per pixel, clears them for the next frame, and shades the pixels.
// Merging takes a minimum, so the picture does not depend on the tasks or on which worker drew
// them. The number of workers is capped (base/core/jobs.h), since each needs a buffer of the
// picture's size.
#pragma once

#include "base/core/arena.h"
#include "base/core/jobs.h"
#include "base/io/hash.h"
#include "base/splats/light_normal.h"
#include "draw/caps.h"
#include "draw/facing.h"
#include "draw/placement.h"
#include "draw/renderer.h"
#include "draw/transparency.h"
#include "raster/layer.h"
#include "raster/splats_blend.h"
#include "raster/texture.h"
#include "raster/triangles.h"
#include "select/view_frame.h"
#include "store/bytes/format.h"
#include "store/clusters/clusters.h"
#include "store/file/point_attributes.h"
#include "store/sets/large_triangles.h"

enum {
    CPU_TASK_SPLATS = 16384,
    CPU_TASK_TRIANGLES = 4096,
    CPU_TASK_CLUSTERS = 32,
    CPU_BAND_ROWS = 16,
    CPU_ENCODE_SIZE = 16384,
    CPU_FIRST_SHIFT = 2, ///< blocks of a depth pyramid's level 0 are 2^2 pixels wide
};

/// A texture, decoded as colour, as data, or both.
typedef struct stp_cpu_texture {
    stp_texture_pyramid as_color, as_data;
    bool has_color, has_data;
    bool is_asked;    ///< scheduled for decoding
    uint64_t arrival; ///< arrival number of its texels (stp_store_texture_arrival)
} stp_cpu_texture;

/// Columns of a splat set (stp_splats) that is drawn.
typedef struct stp_cpu_splats {
    stp_vec3 origin;
    float step;
    const uint16_t* positions;
    const int8_t* normals;
    const uint8_t* materials;
    const uint32_t *shapes, *ranges, *errors; ///< NULL: none
    const stp_splat_group* groups;            ///< NULL: none
    bool plain_coverages, unknown_signs;
} stp_cpu_splats;

/// A draw item with all data for its tasks and pixels. Views of large scenes have a hundred
/// thousand items.
typedef struct stp_cpu_item {
    stp_draw_kind kind;
    uint32_t first_id, count;
    float growth_share; ///< of splats, for stp_raster_splats
    uint32_t first_task;
    uint32_t seed; ///< for holes and hashed alpha: depends only on the item and its place
    uint32_t unit_count, task_units; ///< splats, triangles or clusters: in total, and per task
    stp_raster_camera camera;        ///< maps positions minus `offset`
    float near_factor,
        near_shift; ///< true nearness = near_factor * that of the buffer + near_shift
    float offset[3];
    float normal_matrix[3][3]; ///< item to scene, with scale
    float scale;               ///< scene units per item unit
    float radius;              ///< splat radius, item space
    const stp_draw_item* draw; ///< the list's item
    const stp_draw_run* runs;  ///< NULL: every splat is drawn at any depth
    stp_cpu_splats splats;
    const uint8_t* colors;     ///< colours of the prefix's octave, 3 bytes per splat
    const uint8_t* low_colors; ///< colours of the previous octave, for the first `low_count`
    const uint8_t *coverages, *low_coverages;
    stp_light_normals lights, low_lights;
    uint32_t low_count;
    float blend;           ///< weight of `colors` for the first `low_count`
    stp_store_mesh mesh;   ///< mesh of columns, or
    stp_clusters clusters; ///< mesh of clusters, if it has bytes
    stp_large_triangles large;
    bool reads_texcoords[2];
    stp_store_point_set points;
    const stp_store_material* material;
    stp_mesh_transparency glass; ///< transparency of a mesh
    float cells;                 ///< for a transparent mesh, per item unit (raster/blue_noise.h)
    const stp_texture_pyramid* base_color;
    const stp_texture_pyramid* metallic_roughness;
    const stp_texture_pyramid* emissive;
    const stp_texture_pyramid* normal_map;
    // Occlusion culling of parts of items (occlude.c):
    double occluder_rows[3][4]; ///< from item space to right, down, depth of the pyramid's view
    stp_raster_occluder occluder;
    size_t late; ///< offset of its bits in stp_cpu_eye.late, in units of 16
} stp_cpu_item;

typedef struct stp_cpu_shade_item stp_cpu_shade_item;
typedef struct stp_cpu_shade_material stp_cpu_shade_material;
typedef struct stp_cpu_shade_memory stp_cpu_shade_memory;

typedef struct stp_cpu_worker {
    uint64_t* pixels;              ///< buffer of the current eye, a part of `memory`
    uint64_t* memory;              ///< for the pixels of all eyes, one after the other
    uint64_t** buffers;            ///< buffers of the workers that drew; room for all workers
    stp_cpu_shade_memory* shading; ///< cache of recently shaded surfaces
    stp_arena scratch;
    uint64_t fragments, covered;
    uint64_t splats, triangles; ///< drawn
    uint64_t layer_found;       ///< fragments of the current task between the layer's bounds
    uint64_t layer_pixels;      ///< shaded pixels of the current layer
    bool drew, failed;
    bool drew_opaque; ///< while layers are drawn: whether it drew anything before them, of any eye
} stp_cpu_worker;

/// One eye of a view.
typedef struct stp_cpu_eye {
    stp_view_frame frame;
    stp_image picture;
    // Splats and clusters occluded in the first pass, to be tested again in the second: one bit
    // each.
    uint16_t* late;
    size_t late_capacity;
    uint8_t* late_tasks; ///< whether a task has any such bits
    size_t late_task_capacity;
    bool made;      ///< its pyramid is of the current sample
    float* windows; ///< occlusion test of splats (raster/occluder.h)
    size_t window_capacity;
    uint32_t window_level; ///< pyramid level of the windows
} stp_cpu_eye;

/// Inputs of the selection for samples in two passes.
typedef struct stp_cpu_two_passes {
    const stp_view* view;
    stp_quality quality;
    stp_draw_list* list;
    bool hides_nodes; ///< selection may cull with pyramids
    bool selected;    ///< the list holds the first pass of the next sample
    bool exceeds;     ///< the list exceeds the quality's limit, so the picture was given up
    double select_ms; ///< selection time
} stp_cpu_two_passes;

/// Memory for post-shading effects (effects.h).
typedef struct stp_cpu_effects {
    float* memory;
    size_t capacity;
    stp_depth_pyramid pyramid; ///< for parallel projection, without a culling pyramid
} stp_cpu_effects;

/// Memory for the pixel filter (pixel_filter.h).
typedef struct stp_cpu_pixel_filter {
    uint8_t* memory;
    size_t capacity;
    /// One a pixel of the current eye: 1 where it shows a splat. NULL between frames, and in pictures
    /// that are not filtered
    uint8_t* kinds;
    uint8_t *borders, *scratch;
    bool warned; ///< a warning about missing memory was logged
} stp_cpu_pixel_filter;

/// Memory for the filter (passes.h).
typedef struct stp_cpu_blend {
    stp_raster_plane* planes;
    uint64_t* sums; ///< 2 per pixel
    size_t capacity;
    uint16_t* visible; ///< one bit per splat, like the bits of stp_cpu_item.late
    size_t visible_capacity;
    float* blocks; ///< minimum nearness of planes, then the windows of an occluder
    size_t block_capacity;
    uint32_t block_shift;      ///< 2^shift pixels a side
    stp_splat_texture texture; ///< for STP_FILTER_TEXTURED
    /// Operation on splats that replaces drawing them.
    enum { CPU_BLEND_NONE, CPU_BLEND_PLANES, CPU_BLEND_SPLATS } stage;
} stp_cpu_blend;

/// Layers of transparent surfaces (layers.h).
typedef struct stp_cpu_layers {
    bool possible, of_splats; ///< whether the scene has transparent surfaces, and splats of them
    bool warned;              ///< a warning about missing memory was logged
    uint8_t of_shading[256];  ///< per shading: whether its splats are transparent
    enum {
        /// Transparent surfaces are drawn with the opaque ones, by alpha thresholds
        CPU_LAYERS_NONE,
        CPU_LAYERS_OPAQUE, ///< drawing opaque surfaces
        CPU_LAYERS_PEEL,   ///< drawing a layer
    } stage;
    uint32_t count; ///< layers of the last picture, without the final empty pass
    size_t capacity;
    uint64_t *nearer, *farther; ///< see stp_raster_layer
    float* splats_below;
    /// Per worker and STP_LAYER_MARKED pixels: fragments of the current layer. Only of workers that
    /// drew
    bool* marks;
    size_t mark_count;           ///< of each worker
    bool nearest_only;           ///< the nearest layer stands for all (STP_TRANSPARENCY_NEAREST)
    atomic_uint* optical_depths; ///< per pixel: of all its triangles (transparency.h)
    uint32_t depth_of_opacity[256];
    float* light; ///< 4 per pixel: linear colour of the layers so far, and their transmittance
    /// Per tile of the last picture, whose size this is, row by row: whether its pixels may differ
    /// from those before the first layer
    bool* touched;
    size_t touched_capacity;
    uint32_t width, height;
    uint8_t* alive; ///< per task: whether it may still have visible fragments
    size_t alive_capacity;
} stp_cpu_layers;

/// Sum of frames, each shifted by a fraction of a pixel (passes.h).
typedef struct stp_cpu_accumulation {
    /// Sums of the current eye, 4 per pixel: linear colour times alpha, and alpha
    uint32_t* sums;
    uint32_t* memory;    ///< memory of the sums of all eyes
    uint32_t* linear;    ///< table from sRGB byte to linear, 65535 is 1
    size_t capacity;     ///< pixels
    uint32_t frames;     ///< summed frames; 0: none yet, or outdated
    stp_resting resting; ///< inputs of those frames
} stp_cpu_accumulation;

typedef struct stp_cpu_renderer {
    stp_renderer base;
    stp_store* store;
    const stp_store_directory* directory;
    stp_team team;           ///< for drawing and shading
    stp_cpu_worker* workers; ///< one per thread
    size_t pixel_count;      ///< capacity of the buffers, for all eyes
    float* depths;           ///< true nearness of the pixels of all eyes
    /// 4 per pixel: linear colour and number of covering samples; NULL until supersampling
    float* all_sums;
    size_t sum_count;
    uint8_t* eye_pixels; ///< for pictures of two eyes, one after the other
    size_t eye_pixel_count;
    stp_cpu_texture* textures;
    uint32_t* asked; ///< indices of textures scheduled for decoding; room for all
    stp_cpu_item* items;
    size_t item_count, item_capacity;
    uint64_t large_count;                   ///< triangles tested for drawing together with splats
    uint64_t drawn_splats, drawn_triangles; ///< of the last picture that drew any sample
    uint32_t task_count;
    stp_cpu_eye eyes[STP_EYES_MAX];
    stp_depth_pyramid
        pyramids[STP_EYES_MAX]; ///< depths of the eyes' last pictures; no levels: none
    size_t late_count;          ///< occlusion bits of all items, in units of 16
    stp_cpu_effects effects;
    stp_cpu_pixel_filter pixel_filter;
    stp_cpu_accumulation accumulation;
    stp_cpu_blend blend;
    stp_caps* caps; ///< NULL until a style needs them
    stp_cpu_layers layers;
    stp_front_only front_only;               ///< which splat shadings are drawn from the front only
    uint8_t front_only_shadings[256];        ///< one each
    float decode[256];                       ///< sRGB byte to linear
    uint8_t encode[CPU_ENCODE_SIZE + 3];     ///< read in fours
    float* growths;                          ///< of 256 shadings; NULL: all are 0
    stp_cpu_shade_material* shade_materials; ///< see stp_cpu_make_shade_materials
    stp_cpu_shade_item* shade_items;
    uint32_t* first_ids; ///< first ids of items, ascending
    size_t shade_item_capacity, first_id_capacity;
    uint32_t* id_starts; ///< item of each 2^id_shift-th id
    uint32_t id_shift;
    // this frame
    stp_cpu_two_passes* two_passes; ///< NULL: single pass
    uint32_t eye_count;
    const stp_draw_style* style;
    const stp_sections* sections;
    const stp_visibility* visibility; ///< NULL: everything is shown
    // the current eye (select_eye)
    stp_cpu_eye* eye;
    stp_view_frame frame;
    stp_image* image;
    float *depth, *sums;
    const stp_depth_pyramid* occluding; ///< optional occluders of splats and clusters in this pass
    const stp_cpu_eye* placed;          ///< the eye that items are placed for
    double nearness_scale, nearness_offset; ///< nearness = offset + scale / depth, or scale * depth
    double mesh_depth; ///< depth offset of triangles, in pixel sides at their depth
    uint32_t width, height;
    float splat_size;              ///< pixels; 0: only triangles can be drawn
    uint32_t sample, sample_count; ///< index and number of summed supersamples; 0 and 1: no sums
    uint32_t pattern;              ///< the sample's index, for hashed alpha
    double shift_x, shift_y;
} stp_cpu_renderer;

/// Looks up data and textures for a list's items from `first`; earlier items are already prepared.
/// Failures are logged.
STP_MUST_USE stp_result stp_cpu_prepare_items(stp_cpu_renderer* r, const stp_draw_list* list,
                                              size_t first);
/// Computes matrices of items from `first` for the current eye; of all items if earlier ones are of
/// another eye.
void stp_cpu_place_items(stp_cpu_renderer* r, const stp_draw_list* list, size_t first);
void stp_cpu_destroy_textures(stp_cpu_renderer* r);

/// Factor on splat radii.
static inline float stp_cpu_splat_scale(const stp_cpu_renderer* r)
{
    return r->style->splat_scale > 0.0f ? r->style->splat_scale : 1.0f;
}

/// Draws a task. @return whether parts of it were occluded
bool stp_cpu_draw_task(stp_cpu_renderer* r, const stp_cpu_item* item, uint32_t task, bool late,
                       const stp_raster_target* target, stp_cpu_worker* worker);
/// The item that a task belongs to.
const stp_cpu_item* stp_cpu_item_of_task(const stp_cpu_renderer* r, uint32_t task);
/// Depth bounds of fragments in the current layer, for a worker.
static inline stp_raster_layer stp_cpu_make_layer(const stp_cpu_renderer* r, stp_cpu_worker* worker)
{
    size_t first = (size_t)(worker - r->workers) * r->layers.mark_count;
    return (stp_raster_layer){.nearer = r->layers.nearer,
                              .farther = r->layers.farther,
                              .splats_below = r->layers.splats_below,
                              .found = &worker->layer_found,
                              .marks = r->layers.marks != NULL ? r->layers.marks + first : NULL,
                              .tests_all = r->layers.nearest_only};
}

/// Draws all items from a task into the workers' buffers; of earlier tasks, only content occluded
/// so far for the eye.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged), or STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_cpu_draw_items(stp_cpu_renderer* r, uint32_t first_task);

/// Allocates occlusion bits of items from `first`, whose tasks are counted. @return STP_OK or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cpu_prepare_late(stp_cpu_renderer* r, size_t first);
/// Whether anything drawn so far was occluded for an eye.
bool stp_cpu_is_any_late(const stp_cpu_renderer* r, const stp_cpu_eye* eye);
/// Prepares the occlusion test of splats for the current eye. @return STP_OK or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cpu_prepare_occluder(stp_cpu_renderer* r);
/// Prepares the occlusion test of an item.
void stp_cpu_place_occluder(const stp_cpu_renderer* r, const stp_draw_item* draw,
                            stp_cpu_item* item);
/// Prepares the occlusion test of an item's splats against windows of a view's picture, with blocks
/// of 2^shift pixels per side; `rows` map item space to the view (stp_placement_view_rows).
stp_raster_occluder stp_cpu_make_occluder(const stp_view_frame* frame, const double rows[3][4],
                                          const stp_affine* transform, const float* windows,
                                          uint32_t columns, uint32_t shift);
/// The finest level, 0 or more, whose blocks are so large that splats up to twice the list's size
/// touch few.
uint32_t stp_cpu_choose_level(const stp_cpu_renderer* r, const stp_view_frame* frame,
                              uint32_t level_count);
/// Prepares the occlusion test of all items before `first` with content occluded for the eye.
void stp_cpu_place_late_occluders(stp_cpu_renderer* r, const stp_draw_list* list, size_t first);
/// Whether the pyramid occludes all triangles in a box in item space.
bool stp_cpu_hides(const stp_cpu_renderer* r, const stp_cpu_item* item, stp_box box);
/// Whether there is a pyramid and it occludes a cluster, by the box of its decoded positions. That
/// of the cluster itself may be up to twice as large.
bool stp_cpu_hides_cluster(const stp_cpu_renderer* r, const stp_cpu_item* item,
                           const float* positions, uint32_t count);
/// Writes the nearest of the workers' buffers to `depth`, for rows [begin, end): lower bounds of
/// the true nearness, 0 for background.
void stp_cpu_find_depths(stp_cpu_renderer* r, uint32_t begin, uint32_t end, stp_cpu_worker* worker);

/// Prepares materials for shading: 256 splat shadings, then those of meshes and points, then the
/// same unlit. Called once per renderer. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cpu_make_shade_materials(stp_cpu_renderer* r);
/// Builds the item tables of shading, from `first`, and allocates memory for workers.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cpu_prepare_shading(stp_cpu_renderer* r, size_t first);
void stp_cpu_destroy_shading(stp_cpu_renderer* r);
/// Call before shading each sample: invalidates cached triangles.
void stp_cpu_begin_shading(stp_cpu_renderer* r);

/// Shades rows [begin, end), clears their buffers, and writes the picture or adds to the sums.
void stp_cpu_shade_rows(stp_cpu_renderer* r, uint32_t begin, uint32_t end, stp_cpu_worker* worker);
/// Resolves the sums of all samples into the picture.
void stp_cpu_average_rows(stp_cpu_renderer* r, uint32_t begin, uint32_t end, uint64_t* covered);

/// The view's planes that may cut an item (stp_draw_item.sections), in item space relative to
/// `offset`.
typedef struct stp_cpu_sections {
    uint32_t count;
    float rows[STP_SECTION_PLANES][4]; ///< cut away if row . (x, 1) > 0
} stp_cpu_sections;

void stp_cpu_find_sections(const stp_cpu_renderer* r, const stp_cpu_item* item,
                           stp_cpu_sections* sections);
/// Whether a box in item space is entirely cut away. Adds the bits of planes that intersect it to
/// `mask`.
bool stp_cpu_sections_drop(const stp_cpu_sections* sections, const stp_cpu_item* item, stp_box box,
                           uint32_t* mask);
/// Whether splats of an item that face away are left out.
bool stp_cpu_drops_backs(const stp_cpu_renderer* r, const stp_cpu_item* item);
/// Whether an item may have splats or points of hidden classes.
bool stp_cpu_hides_some(const stp_cpu_renderer* r, const stp_cpu_item* item);
/// Filters splats: drops those that are cut away, hidden or face away, and thins those of a
/// ghost. Sets `wanted`, in the worker's scratch memory, and `share`. @return false if out of
/// memory
bool stp_cpu_filter_splats(const stp_cpu_renderer* r, const stp_cpu_item* item,
                           stp_raster_splats* splats, stp_cpu_worker* worker);

/// Seed of the current sample.
static inline uint32_t stp_cpu_sample_seed(const stp_cpu_renderer* r, const stp_cpu_item* item)
{
    return item->seed + r->pattern * 0x9E3779B1u;
}

/// The nearest of all workers' pixels at a position.
static inline uint64_t stp_cpu_nearest_of_workers(const stp_cpu_renderer* r, size_t at)
{
    uint64_t pixel = STP_RASTER_EMPTY;
    for (uint32_t k = 0; k < r->team.threads; ++k) {
        uint64_t other = r->workers[k].drew ? r->workers[k].pixels[at] : STP_RASTER_EMPTY;
        pixel = other < pixel ? other : pixel;
    }
    return pixel;
}

/// Whether the present pass counts what it draws of an item: surfaces that several passes draw
/// count once.
static inline bool stp_cpu_is_counted(const stp_cpu_renderer* r, const stp_cpu_item* item)
{
    bool first = item->kind != STP_DRAW_MESH || item->glass == STP_TRANSPARENT_EVERYWHERE;
    return r->layers.stage != CPU_LAYERS_PEEL || (r->layers.count == 0 && first);
}

static inline void stp_cpu_count_triangles(const stp_cpu_renderer* r, const stp_cpu_item* item,
                                           uint32_t count, stp_cpu_worker* worker)
{
    worker->triangles += stp_cpu_is_counted(r, item) ? count : 0;
}

/// Which triangles of a mesh item are drawn (stp_raster_mesh.facing).
int32_t stp_cpu_item_facing(const stp_cpu_renderer* r, const stp_cpu_item* item);
/// Whether backs are drawn whatever the materials say.
static inline bool stp_cpu_draws_backs(const stp_cpu_renderer* r)
{
    return stp_draws_backs(r->style, r->sections);
}
/// Share of a ghost's pixels that is drawn.
static inline float stp_cpu_ghost_share(const stp_cpu_renderer* r)
{
    return r->style->ghost > 0.0f ? r->style->ghost : 0.2f;
}

/// Visible part of an item's space.
stp_bounding stp_cpu_bound(const stp_cpu_renderer* r, const stp_cpu_item* item);
/// Makes triangles outside the drawn share of a mesh degenerate: `first` is the index of the first
/// one in the mesh. @return how many are left
uint32_t stp_cpu_drop_triangles(uint32_t* indices, uint32_t first, uint32_t count, float share);

/// Clusters of an item, at most 32.
typedef struct stp_cpu_cluster_range {
    uint32_t begin, end;
    uint32_t wanted; ///< one bit each: only these
    uint32_t hidden; ///< one bit each: set for those that the pyramid occluded
} stp_cpu_cluster_range;

/// Draws clusters, culling those outside the view or occluded. @return false if out of memory
bool stp_cpu_draw_clusters(const stp_cpu_renderer* r, const stp_cpu_item* item,
                           stp_cpu_cluster_range* range, const stp_raster_target* target,
                           stp_cpu_worker* worker);

/// Draws clusters of a level, by what is allowed at their depths. @return false if out of memory
bool stp_cpu_draw_level(const stp_cpu_renderer* r, const stp_cpu_item* item,
                        stp_cpu_cluster_range* range, const stp_raster_target* target,
                        stp_cpu_worker* worker);

/// Whether large triangles replace splats of an item's prefix.
bool stp_cpu_leaves_out_splats(const stp_cpu_item* item);
/// Finds the large triangles of an item that draws only those.
STP_MUST_USE stp_result stp_cpu_find_large(stp_cpu_renderer* r, stp_cpu_item* item);
/// Draws large triangles [begin, end) of an item. @return false if out of memory
bool stp_cpu_draw_large(const stp_cpu_renderer* r, const stp_cpu_item* item, uint32_t begin,
                        uint32_t end, const stp_raster_target* target, stp_cpu_worker* worker);

/// Whether the caller has cancelled the picture (stp_renderer_set_stop).
static inline bool stp_cpu_is_stopped(const stp_cpu_renderer* r)
{
    return stp_renderer_is_stopped(&r->base);
}
