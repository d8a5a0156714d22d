// SPDX-License-Identifier: MIT
//
// The processor's backend. A frame is: prepare the items (matrices, data, textures), draw them in pieces into
// one visibility buffer a worker, then walk the picture in bands: take each pixel's nearest over the workers'
// buffers, emptying them for the next frame, and shade it. Drawing is a minimum, so neither the pieces nor who
// drew them can be seen in the picture. There are no more workers than are of use (base/team.h): each needs a buffer
// as large as the picture.
#pragma once

#include "base/arena.h"
#include "base/hash.h"
#include "base/team.h"
#include "draw/bounding.h"
#include "draw/caps.h"
#include "draw/renderer.h"
#include "draw/resting.h"
#include "draw/transparency.h"
#include "raster/layer.h"
#include "raster/splats_blend.h"
#include "raster/texture.h"
#include "raster/triangles.h"
#include "select/view_frame.h"
#include "store/clusters.h"
#include "store/coloring.h"
#include "store/format.h"
#include "store/large_triangles.h"

enum {
    CPU_PIECE_SPLATS = 16384,
    CPU_PIECE_TRIANGLES = 4096,
    CPU_PIECE_CLUSTERS = 32,
    CPU_BAND_ROWS = 16,
    CPU_ENCODE_SIZE = 16384,
};

/// A texture read as colour, as data, or both.
typedef struct cpu_texture {
    stp_texture_pyramid as_color, as_data;
    bool has_color, has_data;
    bool is_asked;    ///< to be decoded with others
    uint64_t arrival; ///< of its texels (stp_store_texture_arrival)
} cpu_texture;

/// What is drawn of a surfel set (stp_splats), whose columns these are.
typedef struct cpu_surfels {
    stp_vec3 origin;
    float step;
    const uint16_t* positions;
    const int8_t* normals;
    const uint8_t* materials;
    const uint32_t *shapes, *ranges; ///< NULL: none
    const stp_splat_group* groups;   ///< NULL: none
    bool plain_coverages, unknown_signs;
} cpu_surfels;

/// A draw item with all that its pieces and pixels need. Views of large scenes have a hundred thousand.
typedef struct cpu_item {
    stp_draw_kind kind;
    uint32_t first_id, count;
    uint32_t first_piece;
    uint32_t
        seed; ///< of its holes and of hashed alpha: what it is and where, whatever else is drawn
    uint32_t unit_count, piece_units; ///< splats, triangles or clusters: in all, and of a piece
    stp_raster_camera camera;         ///< of positions minus `offset`
    float near_factor,
        near_shift; ///< true nearness = near_factor * that of the buffer + near_shift
    float offset[3];
    float normal_matrix[3][3]; ///< item to scene, not of unit scale
    float scale;               ///< scene units per item unit
    float radius;              ///< of splats, item space
    const stp_draw_item* draw; ///< of the list
    const stp_draw_run* runs;  ///< NULL: each splat is drawn at any depth
    cpu_surfels surfels;
    const uint8_t* colors;     ///< of the prefix's octave
    const uint8_t* low_colors; ///< of the octave before, for the first `low_count`
    const uint8_t *coverages, *low_coverages;
    uint32_t low_count;
    float blend;           ///< share of `colors` there
    stp_store_mesh mesh;   ///< of columns, or
    stp_clusters clusters; ///< of clusters: then it has bytes
    stp_large_triangles large;
    bool reads_texcoords[2];
    stp_store_point_set points;
    const stp_store_material* material;
    stp_mesh_glass glass; ///< of meshes
    float cells;          ///< of a transparent mesh, in an item unit (raster/blue_noise.h)
    const stp_texture_pyramid* base_color;
    const stp_texture_pyramid* metallic_roughness;
    const stp_texture_pyramid* emissive;
    // Where a pyramid hides parts of items (occlude.c):
    double occluder_rows[3][4]; ///< item space to right, down, depth of the pyramid's view
    stp_raster_occluder occluder;
    size_t late; ///< where its bits begin
} cpu_item;

typedef struct cpu_shade_item cpu_shade_item;
typedef struct cpu_shade_material cpu_shade_material;
typedef struct cpu_shade_memory cpu_shade_memory;

typedef struct cpu_worker {
    uint64_t* pixels;          ///< of the eye that is drawn
    uint64_t* memory;          ///< of the pixels of all eyes, one after the other
    uint64_t** buffers;        ///< room for those of all workers
    cpu_shade_memory* shading; ///< what was shaded lately
    stp_arena scratch;
    uint64_t fragments, covered;
    uint64_t layer_found,
        layer_pixels; ///< of the layer that is drawn: fragments of a piece; pixels shaded
    bool drew, failed;
} cpu_worker;

/// One eye of a view.
typedef struct cpu_eye {
    stp_view_frame frame;
    stp_image picture;
    // What the first pass hid from it, and the second looks at again: a bit a splat or cluster.
    uint16_t* late;
    size_t late_capacity;
    uint8_t* late_pieces; ///< whether a piece has any
    size_t late_piece_capacity;
    bool made;      ///< its pyramid is of the sample that is drawn
    float* windows; ///< what splats are looked up in (raster/occluder.h)
    size_t window_capacity;
    uint32_t window_level; ///< of the pyramid
} cpu_eye;

/// What samples in two passes are selected with.
typedef struct cpu_two_passes {
    const stp_view* view;
    stp_quality quality;
    stp_draw_list* list;
    bool hides_nodes; ///< selection may leave out what pyramids hide
    bool selected;    ///< the first pass of the next sample is in the list
    double select_ms; ///< that it took to select
} cpu_two_passes;

/// Memory of what is done with a picture after shading (effects.h).
typedef struct cpu_effects {
    float* memory;
    size_t capacity;
    stp_depth_pyramid pyramid; ///< in parallel projection, where culling has none
} cpu_effects;

/// Memory of the filter (blend.h).
typedef struct cpu_blend {
    stp_raster_plane* planes;
    uint64_t* sums; ///< 2 a pixel
    size_t capacity;
    uint16_t* visible; ///< a bit a surfel, as of those that are hidden (cpu_item.late)
    size_t visible_capacity;
    float* blocks; ///< the least nearness of planes, then the windows of an occluder
    size_t block_capacity;
    uint32_t block_shift;      ///< 2^shift pixels a side
    stp_splat_texture texture; ///< of STP_FILTER_TEXTURED
    /// What is done with splats instead of drawing them.
    enum { CPU_BLEND_NONE, CPU_BLEND_PLANES, CPU_BLEND_SPLATS } stage;
} cpu_blend;

/// Layers of transparent surfaces (layers.h).
typedef struct cpu_layers {
    bool possible, of_splats; ///< whether the scene has such surfaces, and splats of them
    bool told;                ///< that there is no memory
    uint8_t of_shading[256];  ///< whether splats of a shading are transparent
    enum {
        CPU_LAYERS_NONE,   ///< transparent surfaces are drawn with the others, by thresholds
        CPU_LAYERS_OPAQUE, ///< what is opaque is drawn
        CPU_LAYERS_PEEL,   ///< a layer is drawn
    } stage;
    uint32_t count; ///< passes of the last picture
    size_t capacity;
    uint64_t *nearer, *farther; ///< see stp_raster_layer
    float* splats_below;
    float* light; ///< 4 a pixel: linear colour of the layers so far, and how much gets through them
    uint8_t* alive; ///< of each piece: whether it may still have something to draw
    size_t alive_capacity;
} cpu_layers;

/// The sum of frames that were each shifted by a part of a pixel (accumulate.h).
typedef struct cpu_accumulation {
    uint32_t* sums; ///< of the eye that is drawn, 4 a pixel: linear colour and frames that cover it
    uint32_t* memory;    ///< of the sums of all eyes
    uint32_t* linear;    ///< of sRGB bytes
    size_t capacity;     ///< pixels
    uint32_t frames;     ///< summed; 0: none yet, or no longer of any use
    stp_resting resting; ///< what they are of
} cpu_accumulation;

typedef struct cpu_renderer {
    stp_renderer base;
    stp_store* store;
    const stp_store_directory* directory;
    stp_team team;       ///< draws and shades
    cpu_worker* workers; ///< one for each of its threads
    size_t pixel_count;  ///< of all eyes, that buffers have room for
    float* depths;       ///< of all eyes
    float* all_sums;     ///< 4 a pixel: linear colour and samples covered; NULL until supersampling
    size_t sum_count;
    uint8_t* eye_pixels; ///< of two eyes' pictures, one after the other
    size_t eye_pixel_count;
    cpu_texture* textures;
    uint32_t* asked; ///< room for one index a texture
    cpu_item* items;
    size_t item_count, item_capacity;
    uint64_t large_count; ///< triangles looked at beside splats
    uint32_t piece_count;
    cpu_eye eyes[STP_EYES_MOST];
    stp_depth_pyramid pyramids[STP_EYES_MOST]; ///< of the eyes' last pictures; no levels: none
    size_t late_count;                         ///< of bits of all items, in sixteens
    cpu_effects effects;
    cpu_accumulation accumulation;
    cpu_blend blend;
    stp_caps* caps; ///< NULL until a style wants them
    cpu_layers layers;
    float decode[256];                   ///< sRGB bytes to linear
    uint8_t encode[CPU_ENCODE_SIZE + 3]; ///< read four at a time
    cpu_shade_material* shade_materials; ///< see cpu_make_shade_materials
    cpu_shade_item* shade_items;
    uint32_t* first_ids; ///< of items, ascending
    size_t shade_item_capacity, first_id_capacity;
    uint32_t* id_starts; ///< item of every 2^id_shift-th id
    size_t id_start_capacity;
    uint32_t id_shift;
    // this frame
    cpu_two_passes* two_passes; ///< NULL: it is drawn in one
    uint32_t eye_count;
    const stp_draw_style* style;
    const stp_sections* sections;
    const stp_visibility* visibility; ///< NULL: all is shown
    // the eye that is drawn (cpu_look_through)
    cpu_eye* eye;
    stp_view_frame frame;
    stp_image* image;
    float *depth, *sums;
    const stp_depth_pyramid* occluding; ///< NULL, or what hides splats and clusters of this pass
    const cpu_eye* placed;              ///< the eye that items are placed for
    double nearness_scale, nearness_offset; ///< nearness = offset + scale / depth, or scale * depth
    double mesh_depth; ///< how far triangles are put behind their place, in sides of a pixel there
    uint32_t width, height;
    float splat_size;              ///< of what may be drawn; 0: no splats
    uint32_t sample, sample_count; ///< which of the supersamples
    uint32_t pattern;              ///< the sample again, for hashed alpha
    double shift_x, shift_y;
} cpu_renderer;

/// What the buffer's nearness of an item says of where it really is.
static inline float cpu_true_nearness(const cpu_item* item, float nearness)
{
    return item->near_factor * nearness + item->near_shift;
}

/// Looks up data and textures for a list's items, from `first` on; those before were prepared by an earlier call.
/// Failures are logged.
STP_MUST_USE stp_result cpu_prepare_items(cpu_renderer* r, const stp_draw_list* list, size_t first);
/// Makes matrices of items from `first` on for the eye that is drawn; of all items where those before are of another eye.
void cpu_place_items(cpu_renderer* r, const stp_draw_list* list, size_t first);
void cpu_destroy_textures(cpu_renderer* r);

/// What radii of splats are multiplied by.
static inline float cpu_splat_scale(const cpu_renderer* r)
{
    return r->style->splat_scale > 0.0f ? r->style->splat_scale : 1.0f;
}

/// Draws a piece. @return whether some of it was hidden
bool cpu_draw_piece(cpu_renderer* r, const cpu_item* item, uint32_t piece, bool late,
                    const stp_raster_target* target, cpu_worker* worker);
/// The item that a piece belongs to.
const cpu_item* cpu_item_of_piece(const cpu_renderer* r, uint32_t piece);
/// What a worker's fragments of the layer that is drawn must lie between.
static inline stp_raster_layer cpu_make_layer(const cpu_renderer* r, cpu_worker* worker)
{
    return (stp_raster_layer){.nearer = r->layers.nearer,
                              .farther = r->layers.farther,
                              .splats_below = r->layers.splats_below,
                              .found = &worker->layer_found};
}

/// Draws all items into the workers' buffers, from a piece on; of those before, what was hidden so far from the eye.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result cpu_draw_items(cpu_renderer* r, uint32_t first_piece);

/// Room for the bits of items from `first` on, whose pieces are counted. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result cpu_prepare_late(cpu_renderer* r, size_t first);
/// Whether anything was hidden from an eye in what is drawn so far.
bool cpu_is_any_late(const cpu_renderer* r, const cpu_eye* eye);
/// Makes ready what splats ask of the pyramid of the eye that is drawn. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result cpu_prepare_occluder(cpu_renderer* r);
/// Makes ready what of the pyramid an item asks.
void cpu_place_occluder(const cpu_renderer* r, const stp_draw_item* draw, cpu_item* item);
/// What splats of an item ask of windows of a view's picture, whose blocks are 2^shift pixels a side; `rows` lead from the
/// item to the view (stp_placement_view_rows).
stp_raster_occluder cpu_make_occluder(const stp_view_frame* frame, const double rows[3][4],
                                      const stp_affine* transform, const float* windows,
                                      uint32_t columns, uint32_t shift);
/// The finest level, 0 or more, of blocks of which splats up to twice the list's size touch few.
uint32_t cpu_choose_level(const cpu_renderer* r, const stp_view_frame* frame, uint32_t level_count);
/// Grows an array to so many elements of a size at least. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result cpu_grow(stp_context* context, void** memory, size_t* capacity,
                                 size_t wanted, size_t size);
/// The same of all items before `first` of which something was hidden from the eye.
void cpu_place_late_occluders(cpu_renderer* r, const stp_draw_list* list, size_t first);
/// Whether the pyramid hides a box of the item's space.
bool cpu_hides(const cpu_renderer* r, const cpu_item* item, stp_box box);
/// The nearness of what is in the buffers: at most as near as it is.
void cpu_find_depths(cpu_renderer* r, uint32_t begin, uint32_t end, cpu_worker* worker);

/// Materials as shading wants them: 256 of surfels' shadings, then all of meshes and points, then the same unlit.
/// Once a renderer. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result cpu_make_shade_materials(cpu_renderer* r);
/// Makes what shading looks items up in, from `first` on, and gives workers memory.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result cpu_prepare_shading(cpu_renderer* r, size_t first);
void cpu_destroy_shading(cpu_renderer* r);
/// Before the shading of each sample: what was remembered of triangles is no longer so.
void cpu_begin_shading(cpu_renderer* r);

/// Shades rows [begin, end), empties them, and writes the picture or adds to the sums.
void cpu_shade_rows(cpu_renderer* r, uint32_t begin, uint32_t end, cpu_worker* worker);
/// Turns the sums of all samples into the picture.
void cpu_average_rows(cpu_renderer* r, uint32_t begin, uint32_t end, uint64_t* covered);

/// A triangle with all that its corners have.
typedef struct cpu_triangle {
    float position[3][3]; ///< minus the item's offset
    float texcoord[2][3][2];
    float color[3][4];  ///< linear, 1 is full
    stp_vec3 normal[3]; ///< not of unit length
    bool has_texcoord[2], has_color, has_normal;
} cpu_triangle;

/// 16-bit octahedral; not of unit length.
stp_vec3 cpu_decode_normal(const int16_t* code);

/// Reads triangles one after the other; those that lie near the one before are found faster.
typedef struct cpu_reader {
    const cpu_item* item; ///< that the last triangle belonged to; NULL: none yet
    uint32_t index;       ///< of the last triangle
    cpu_triangle triangle;
    const cpu_item* cluster_item; ///< that the open cluster belongs to; NULL: none
    stp_cluster cluster;
} cpu_reader;

/// Triangle `index` of a mesh item; valid until the next call.
const cpu_triangle* cpu_read_triangle(cpu_reader* reader, const cpu_item* item, uint32_t index);
/// The same of a mesh of clusters, from that which holds it.
void cpu_read_from_cluster(const cpu_item* item, const stp_cluster* cluster, uint32_t index,
                           cpu_triangle* out);

/// What the last fragment's triangle had in common with its other fragments.
typedef struct cpu_keep_memory {
    uint32_t triangle; ///< UINT32_MAX: none yet
    float w[3], density;
    uint32_t pattern; ///< key of its thresholds
    cpu_reader reader;
} cpu_keep_memory;

/// The view's planes that may cut an item (stp_draw_item.sections), in its space minus `offset`.
typedef struct cpu_cuts {
    uint32_t count;
    float rows[STP_SECTION_PLANES][4]; ///< cut away where row . (x, 1) > 0
} cpu_cuts;

void cpu_find_cuts(const cpu_renderer* r, const cpu_item* item, cpu_cuts* cuts);
/// Whether all of a box of the item's space is cut away. Adds the bits of the cuts that go through it to `mask`.
bool cpu_cuts_drop(const cpu_cuts* cuts, const cpu_item* item, stp_box box, uint32_t* mask);
/// Whether an item may have splats or points of hidden classes.
bool cpu_hides_some(const cpu_renderer* r, const cpu_item* item);
/// Leaves of splats (by their centres) what is neither cut away nor hidden, and makes ghosts of those of a ghost: sets `wanted`,
/// in the worker's scratch memory, and `share`. @return false where memory runs out
bool cpu_cut_splats(const cpu_renderer* r, const cpu_item* item, stp_raster_splats* splats,
                    cpu_worker* worker);

/// Whether a fragment of a cut-out or transparent material, or of what is cut or a ghost, is there.
typedef struct cpu_keep {
    const cpu_renderer* renderer;
    const cpu_item* item;
    uint32_t first_triangle;
    cpu_keep_memory* memory;
    const cpu_cuts* cuts;
    uint32_t cut_mask; ///< bits of those that may cut what is drawn
} cpu_keep;

bool cpu_keep_fragment(const void* user, uint32_t triangle, float weight1, float weight2,
                       uint32_t x, uint32_t y);
/// The seed for the sample that is drawn.
static inline uint32_t cpu_sample_seed(const cpu_renderer* r, const cpu_item* item)
{
    return item->seed + r->pattern * 0x9E3779B1u;
}

bool cpu_item_needs_keep(const cpu_item* item);
/// The part of a ghost's pixels that is drawn.
static inline float cpu_ghost_share(const cpu_renderer* r)
{
    return r->style->ghost > 0.0f ? r->style->ghost : 0.2f;
}

stp_vec2 cpu_mesh_uv(const cpu_triangle* triangle, const stp_store_texture_use* use,
                     const float weight[3]);
/// Texels of `pyramid` along one item unit of a triangle.
float cpu_mesh_density(const cpu_triangle* triangle, const stp_store_texture_use* use,
                       const stp_texture_pyramid* pyramid);
/// Base colour with texture and vertex colours, at a point of a triangle whose pixel is `footprint` texels wide.
void cpu_mesh_color(const cpu_item* item, const cpu_triangle* triangle, const float weight[3],
                    float footprint, float out[4]);

/// What of an item's space is seen.
stp_bounding cpu_bound(const cpu_renderer* r, const cpu_item* item);
/// Makes degenerate what does not belong to the share of a mesh's triangles: `first` is the first one's index in it.
void cpu_drop_triangles(uint32_t* indices, uint32_t first, uint32_t count, float share);

/// Clusters of an item, at most 32.
typedef struct cpu_cluster_range {
    uint32_t begin, end;
    uint32_t wanted; ///< a bit each: only these
    uint32_t hidden; ///< a bit each: those that the pyramid hid are set
} cpu_cluster_range;

/// Draws clusters without those outside the view or hidden. @return false where memory runs out
bool cpu_draw_clusters(const cpu_renderer* r, const cpu_item* item, cpu_cluster_range* range,
                       const stp_raster_target* target, cpu_worker* worker);

/// Whether large triangles replace splats of an item's prefix.
bool cpu_leaves_out_splats(const cpu_item* item);
/// Finds the large triangles of an item that draws these alone.
STP_MUST_USE stp_result cpu_find_large(cpu_renderer* r, cpu_item* item);
/// Draws [begin, end) of them. @return false where memory runs out
bool cpu_draw_large(const cpu_renderer* r, const cpu_item* item, uint32_t begin, uint32_t end,
                    const stp_raster_target* target, cpu_worker* worker);

/// Whether the caller abandons the picture (stp_renderer_set_stop).
static inline bool cpu_is_stopped(const cpu_renderer* r)
{
    return stp_renderer_is_stopped(&r->base);
}
