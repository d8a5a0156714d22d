// SPDX-License-Identifier: MIT
//
// The OpenGL backend. A frame is:
//
//   items     the list's data is uploaded to the pool (upload.h), and becomes blocks that shaders
//             read (item_commands.c)
//   drawn     splats as points, larger ones as quads, triangles: one command each, into the
//             visibility buffer; in two passes: first those not occluded in the last picture
//             (gl_passes.h)
//   shaded    a compute pass looks up each pixel's id and lights it; then effects and averages
//
// Each pass is a file with create, draw and destroy, and owns its program. Programs depend on the
// number of pages and the shape of splats, and are recreated if these change.
#pragma once

#include "draw/facing.h"
#include "draw/gl/cluster_shares.h"
#include "draw/gl/conversions.h"
#include "draw/gl/gl.h"
#include "draw/gl/gl_passes.h"
#include "draw/gl/gl_program.h"
#include "draw/gl/pool.h"
#include "draw/gl/raster_pass.h"
#include "draw/gl/splat_choice.h"
#include "draw/gl/timer.h"
#include "draw/placement.h"
#include "draw/renderer.h"
#include "draw/shaders/interface.h"
#include "store/clusters/clusters.h"

typedef struct stp_gl_renderer stp_gl_renderer;

/// Programs of the splat passes.
typedef struct stp_gl_splat_pass {
    GLuint points, large, vertex_array;
    GLuint large_buffer; ///< large_block
} stp_gl_splat_pass;

typedef struct stp_gl_triangle_pass {
    GLuint plain, keep, vertex_array;
} stp_gl_triangle_pass;

typedef struct stp_gl_shade_pass {
    GLuint shade, kinds, sums, average, add; ///< all but the first are created on first use
    GLuint counters;                         ///< one word per stp_gl_counter
    GLuint copied; ///< copy of the counters: drivers move a buffer that is read to the CPU's memory
} stp_gl_shade_pass;

/// Render targets. Sizes are those of the last picture.
typedef struct stp_gl_target {
    uint32_t width, height; ///< size of one eye's picture
    uint32_t eye_count;
    uint32_t full_width;               ///< width of the picture: its last column may be no eye's
    GLuint ids, nearness, framebuffer; ///< visibility buffer of one eye
    GLuint picture;                    ///< RGBA8: the eyes side by side
    GLuint depths;                     ///< R32F: true nearness, one eye above the other
    GLuint sums;                       ///< RGBA32F, of the picture's size; 0: not needed yet
} stp_gl_target;

/// Commands of one multi-draw, and their place in the frame's buffer.
typedef struct stp_gl_commands {
    struct stp_gl_command {
        uint32_t count, instance_count, first, base;
    } * commands;
    size_t count, capacity;
    GLintptr offset, count_offset;
} stp_gl_commands;

/// Counters of the shaders: pixels of the picture and of transparent layers, and splats that the
/// compute rasteriser drew.
typedef enum stp_gl_counter {
    GL_COUNTER_COVERED,
    GL_COUNTER_LAYERS,
    GL_COUNTER_SPLATS,
    GL_COUNTERS = 4
} stp_gl_counter;

typedef enum stp_gl_command_kind {
    GL_COMMANDS_SPLATS,
    GL_COMMANDS_TRIANGLES,
    GL_COMMANDS_KEEP,                              ///< triangles with per-fragment tests
    GL_COMMANDS_CULLED,                            ///< the kinds above may be occluded
    GL_COMMANDS_GLASS_SPLATS = GL_COMMANDS_CULLED, ///< for layers: possibly transparent
    GL_COMMANDS_GLASS_TRIANGLES,
    GL_COMMAND_KINDS
} stp_gl_command_kind;

/// Data of an item kept after its block is built, to place it again for each sample.
typedef struct stp_gl_placed {
    const stp_draw_item* draw;
    float offset[3];
    float radius;    ///< splat radius, item space; for splats with shapes, a size step of their set
    float scale;     ///< factor on radii
    stp_vec3 origin; ///< origin of the splats' grid, item space
    float step;
    bool unknown_signs; ///< the signs of the splats' normals are unknown
} stp_gl_placed;

/// The frame's blocks, in CPU memory.
typedef struct stp_gl_frame {
    item_block* items;
    stp_gl_placed* placed;
    size_t item_count, item_capacity, placed_capacity;
    record_block* records;
    size_t record_count, record_capacity;
    chunk_block* chunks;
    size_t chunk_count, chunk_capacity;
    uint32_t* lookup;
    size_t lookup_count, lookup_capacity;
    uint32_t id_shift;
    stp_gl_commands commands[GL_COMMAND_KINDS];
    stp_gl_ring ring; ///< for uploading all of it
    /// What shaders read: a copy of the ring's part in the GPU's own memory. Reading mapped memory
    /// for every vertex crosses the bus each time.
    GLuint buffer;
    uint64_t buffer_size;
    GLintptr items_offset, records_offset, chunks_offset, lookup_offset, view_offset;
    GLintptr groups_offset;  ///< first group of each splat command, for the compute rasteriser
    uint64_t group_count;    ///< groups of all splat commands
    uint32_t missing;        ///< items coarser than the list wants, for all eyes
    uint32_t coming;         ///< uploads postponed to later frames
    uint64_t uploaded_bytes; ///< for all eyes
    bool beside;             ///< large triangles of the previous set are drawn
    uint64_t large_count;
    uint64_t drawn_triangles; ///< of clusters in view, and all large ones; of all eyes
    stp_gl_cluster_shares shares;
    uint32_t* marks; ///< one bit per cluster of a mesh: it contains large triangles of the item
    size_t mark_capacity;
} stp_gl_frame;

/// Bounds of an octave's splat positions, in grid units.
typedef struct stp_gl_octave_box {
    uint16_t low[3], high[3];
    uint16_t largest; ///< code of the maximum radius (base/splats/splat_codes.h)
    bool replaced;    ///< large triangles replace some
} stp_gl_octave_box;

/// First entries of each kind of data in the pool's table.
typedef struct stp_gl_entries {
    uint32_t* sets;       ///< per splat set: two per octave, positions and colours
    uint32_t meshes;      ///< one per item
    uint32_t textures;    ///< two per texture: read as colour, and as data
    uint32_t* point_sets; ///< one per chunk
    /// Boxes of uploaded octaves, indexed by half the number of their position entry
    stp_gl_octave_box* boxes;
    uint32_t count;
} stp_gl_entries;

/// Data read back from the GPU.
typedef struct stp_gl_readback {
    float* depth;
    size_t capacity;
    bool has_depth; ///< `depth` holds the last picture's
} stp_gl_readback;

/// CPU times of a picture's steps in milliseconds: see stp_draw_gl_stats.
typedef struct stp_gl_clock {
    double prepare, issue, read;
} stp_gl_clock;

/// Messages of a debug context.
typedef struct stp_gl_debug {
    uint32_t errors;
    char message[400]; ///< the first error
} stp_gl_debug;

/// Steps that are left out, to measure what they gain (`stipple-lab bench spt --backend gl`) and to
/// test that they change no pixel.
typedef struct stp_gl_omissions {
    bool occlusion; ///< always a single pass
    bool groups;    ///< draws invisible groups too
    bool shading;   ///< pictures end with the visibility buffer
} stp_gl_omissions;

/// Sum of frames of a view at rest.
typedef struct stp_gl_accumulation {
    uint32_t frames; ///< summed frames; 0: none yet, or outdated
    uint32_t width, height;
    stp_resting resting; ///< inputs of those frames
} stp_gl_accumulation;

struct stp_gl_renderer {
    stp_renderer base;
    stp_gl gl;
    stp_store* store;
    const stp_store_directory* directory;
    bool is_software;
    char device[160];
    uint64_t upload_bytes; ///< per frame; 0: all
    stp_gl_debug* debug;
    stp_gl_pool pool;
    stp_gl_conversions conversions; ///< uploads on their way to the pool
    stp_gl_entries entries;
    uint32_t program_pages; ///< page count of the programs; 0: no programs yet
    bool program_squares;   ///< programs draw splats as squares
    stp_gl_splat_pass splats;
    stp_gl_raster_pass raster;
    stp_gl_splat_choice splat_choice;
    stp_gl_filter_pass filter;
    stp_gl_occlusion_pass occlusion;
    stp_gl_omissions omits;
    stp_gl_triangle_pass triangles;
    stp_gl_shade_pass shade;
    stp_gl_effect_pass effects;
    stp_gl_pixel_filter_pass pixel_filter;
    stp_gl_cap_pass cap_pass;
    stp_gl_layer_pass layer_pass;
    stp_front_only front_only;        ///< which splat shadings are drawn from the front only
    uint8_t front_only_shadings[256]; ///< one each
    stp_gl_timer timer;
    stp_gl_target target;
    stp_gl_frame frame;
    float largest_growth;              ///< of the shadings; 0: none
    GLuint light_materials, materials; ///< constant storage buffers
    stp_gl_readback* readback;
    stp_gl_clock clock;
    stp_gl_accumulation accumulation;
    float point_extent; ///< maximum radius of a point in pixels
    // this picture
    stp_placement placement;
    uint32_t eye;
    const stp_view* view;             ///< the whole view, with all eyes
    const stp_visibility* visibility; ///< NULL: everything is shown
    const stp_draw_style* style;
    const stp_draw_list* list;
    stp_result failure;              ///< why an upload failed
    uint32_t draw_calls, dispatches; ///< numbers in the last picture's last sample
    uint32_t counted_samples;        ///< samples that the last call drew
    uint64_t listed_splats; ///< of the last picture, whose list the caller may have changed since
};

/// Defines for programs that read pages. @return `text`
const char* stp_gl_page_defines(const stp_gl_renderer* r, const char* more, char* text,
                                size_t size);

/// Shaders of splats too large for points.
const char* stp_gl_large_vertex_shader(const stp_gl_renderer* r);
const char* stp_gl_large_fragment_shader(const stp_gl_renderer* r);
STP_MUST_USE stp_result stp_gl_splat_pass_create(stp_gl_renderer* r);
void stp_gl_splat_pass_destroy(stp_gl_renderer* r);
/// Clears the queue of large splats before splats are drawn.
void stp_gl_splat_pass_begin(stp_gl_renderer* r);
STP_MUST_USE stp_result stp_gl_splat_pass_points(stp_gl_renderer* r,
                                                 const stp_gl_splat_source* source, GLuint program);
/// Draws the queued large splats.
void stp_gl_splat_pass_large(stp_gl_renderer* r, GLuint program);
/// Sets the viewport and state for splats and triangles, and binds the view's framebuffer.
void stp_gl_set_visible_state(stp_gl_renderer* r);

STP_MUST_USE stp_result stp_gl_triangle_pass_create(stp_gl_renderer* r);
void stp_gl_triangle_pass_destroy(stp_gl_renderer* r);
STP_MUST_USE stp_result stp_gl_triangle_pass_draw(stp_gl_renderer* r);

// portions.c
/// Draws the commands of a kind, at `offset` of the bound buffer. @return STP_OK, or
/// STP_ERROR_CANCELLED (not logged) if the picture is cancelled (stp_renderer_set_stop)
STP_MUST_USE stp_result stp_gl_portion_draw(stp_gl_renderer* r, GLenum mode,
                                            const stp_gl_commands* commands, GLintptr offset,
                                            GLintptr count_offset);
/// If the picture may be cancelled, waits for everything drawn so far. @return as
/// stp_gl_portion_draw
STP_MUST_USE stp_result stp_gl_portion_wait(stp_gl_renderer* r);

STP_MUST_USE stp_result stp_gl_shade_pass_create(stp_gl_renderer* r);
void stp_gl_shade_pass_destroy(stp_gl_renderer* r);
/// Draws one sample into the picture or the sums. `kinds`: records what each pixel shows, for the
/// pixel filter. @return as stp_gl_program_create
STP_MUST_USE stp_result stp_gl_shade_pass_draw(stp_gl_renderer* r, bool sums, bool kinds);
/// Adds the picture to the sums. @return as stp_gl_program_create
STP_MUST_USE stp_result stp_gl_shade_pass_add(stp_gl_renderer* r);
/// Resolves the sums into the picture. @return as stp_gl_program_create
STP_MUST_USE stp_result stp_gl_shade_pass_average(stp_gl_renderer* r);
/// Sets all counters to 0.
void stp_gl_shade_pass_clear(stp_gl_renderer* r);
void stp_gl_shade_pass_clear_counter(stp_gl_renderer* r, stp_gl_counter counter);
/// Waits for the GPU. @return a counter since the reset
uint32_t stp_gl_shade_pass_read(stp_gl_renderer* r, stp_gl_counter counter);

/// Creates textures and framebuffer of the view's size. @return STP_OK, STP_ERROR_LIMIT,
/// STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_gl_target_make(stp_gl_renderer* r, const stp_view* view, bool sums);
void stp_gl_target_destroy(stp_gl_renderer* r);
/// Runs a compute program of GROUP_SIDE x GROUP_SIDE pixels a group over a picture.
void stp_gl_dispatch_pixels(stp_gl_renderer* r, GLuint program, uint32_t width, uint32_t height);
GLuint stp_gl_make_texture(const stp_gl* gl, GLenum format, uint32_t width, uint32_t height,
                           const char* label);
/// Reads a texture of four bytes per pixel, in bands of whole rows of at most `band_bytes`, or one
/// row. Waits.
void stp_gl_read_texture(const stp_gl* gl, GLuint texture, GLenum format, GLenum type,
                         uint32_t width, uint32_t height, uint64_t band_bytes, void* pixels);

/// Uploads the list's data to the pool, within the frame's upload limit, and builds blocks, records
/// and commands. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_UNSUPPORTED (the context is
/// lost), or as the store's functions; logged
STP_MUST_USE stp_result stp_gl_frame_make(stp_gl_renderer* r);
/// Places items again after the placement's shift has changed; `pattern` is the sample's number.
void stp_gl_frame_place(stp_gl_renderer* r, uint32_t pattern);
/// Uploads everything to the GPU, and binds it.
STP_MUST_USE stp_result stp_gl_frame_send(stp_gl_renderer* r, const view_block* view);
void stp_gl_frame_destroy(stp_gl_renderer* r);
/// Appends a command of a kind, with a record. @return the record; NULL if out of memory
record_block* stp_gl_frame_add_command(stp_gl_renderer* r, stp_gl_command_kind kind,
                                       uint32_t count);
/// Appends another command for the last record. @return false if out of memory
bool stp_gl_frame_repeat_command(stp_gl_renderer* r, stp_gl_command_kind kind, uint32_t count);
/// Appends a chunk of an item's splats. NULL if out of memory.
chunk_block* stp_gl_frame_add_chunk(stp_gl_renderer* r, item_block* item);

/// Samples of a picture, each drawn separately.
typedef struct stp_gl_sample_range {
    uint32_t side, first, end; ///< samples [first, end) of side x side
    bool sums;                 ///< the picture is their mean, including those before `first`
    bool bytes;                ///< each is resolved to a picture first, for post-processing
    bool scattered;            ///< consecutive samples lie far apart
} stp_gl_sample_range;

/// Draws samples of an eye's picture. @return result of the first failing step
STP_MUST_USE stp_result stp_gl_draw_eye(stp_gl_renderer* r, uint32_t eye,
                                        const stp_gl_sample_range* range);
/// Restores the context state that draw_gl.h promises.
void stp_gl_leave_state(const stp_gl_renderer* r);
/// Creates programs for the current number of pages and the style's shape of splats. @return as
/// stp_gl_program_create
STP_MUST_USE stp_result stp_gl_make_programs(stp_gl_renderer* r);

/// Uploads the store's materials, once. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_gl_materials_create(stp_gl_renderer* r);

/// Binds the inputs of all passes over pixels and splats.
void stp_gl_bind_frame(stp_gl_renderer* r);
