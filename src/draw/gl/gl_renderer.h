// SPDX-License-Identifier: MIT
//
// The OpenGL backend. A frame is:
//
//   items     the list's data is uploaded to the pool (upload.h), and becomes blocks that shaders
//             read (item_commands.c)
//   drawn     splats as points, larger ones as quads, triangles: one command each, into the
//             visibility buffer; in two passes: first those not occluded in the last picture
//             (occlusion_pass.h)
//   shaded    a compute pass looks up each pixel's id and lights it; then effects and averages
//
// Each pass is a file with create, draw and destroy, and owns its program. Programs depend on the
// number of pages and the shape of splats, and are recreated if these change.
#pragma once

#include "draw/gl/cap_pass.h"
#include "draw/gl/cluster_shares.h"
#include "draw/gl/effect_pass.h"
#include "draw/gl/filter_pass.h"
#include "draw/gl/gl.h"
#include "draw/gl/gl_program.h"
#include "draw/gl/layer_pass.h"
#include "draw/gl/occlusion_pass.h"
#include "draw/gl/pool.h"
#include "draw/gl/raster_pass.h"
#include "draw/gl/splat_choice.h"
#include "draw/gl/timer.h"
#include "draw/placement.h"
#include "draw/renderer.h"
#include "draw/resting.h"
#include "draw/shaders/interface.h"
#include "store/clusters/clusters.h"

typedef struct gl_renderer gl_renderer;

/// Programs of the splat passes.
typedef struct gl_splat_pass {
    GLuint points, large, vertex_array;
    GLuint large_buffer; ///< large_block
} gl_splat_pass;

typedef struct gl_triangle_pass {
    GLuint plain, keep, vertex_array;
} gl_triangle_pass;

typedef struct gl_shade_pass {
    GLuint shade, sums, average, add; ///< all but the first are created on first use
    GLuint counters;                  ///< one word per gl_counter
    GLuint copied; ///< copy of the counters: drivers move a buffer that is read to the CPU's memory
} gl_shade_pass;

/// Render targets. Sizes are those of the last picture.
typedef struct gl_target {
    uint32_t width, height; ///< size of one eye's picture
    uint32_t eye_count;
    uint32_t full_width;               ///< width of the picture: its last column may be no eye's
    GLuint ids, nearness, framebuffer; ///< visibility buffer of one eye
    GLuint picture;                    ///< RGBA8: the eyes side by side
    GLuint depths;                     ///< R32F: true nearness, one eye above the other
    GLuint sums;                       ///< RGBA32F, of the picture's size; 0: not needed yet
} gl_target;

/// Commands of one multi-draw, and their place in the frame's buffer.
typedef struct gl_commands {
    struct gl_command {
        uint32_t count, instance_count, first, base;
    } * commands;
    size_t count, capacity;
    GLintptr offset, count_offset;
} gl_commands;

/// Counters of the shaders: pixels of the picture, and of transparent layers.
typedef enum gl_counter { GL_COUNTER_COVERED, GL_COUNTER_LAYERS, GL_COUNTERS = 4 } gl_counter;

typedef enum gl_command_kind {
    GL_COMMANDS_SPLATS,
    GL_COMMANDS_TRIANGLES,
    GL_COMMANDS_KEEP,                              ///< triangles with per-fragment tests
    GL_COMMANDS_CULLED,                            ///< the kinds above may be occluded
    GL_COMMANDS_GLASS_SPLATS = GL_COMMANDS_CULLED, ///< for layers: possibly transparent
    GL_COMMANDS_GLASS_TRIANGLES,
    GL_COMMAND_KINDS
} gl_command_kind;

/// Data of an item kept after its block is built, to place it again for each sample.
typedef struct gl_placed {
    const stp_draw_item* draw;
    float offset[3];
    float radius;    ///< splat radius, item space; for splats with shapes, a size step of their set
    float scale;     ///< factor on radii
    stp_vec3 origin; ///< origin of the surfels' grid, item space
    float step;
    bool unknown_signs; ///< the signs of the surfels' normals are unknown
} gl_placed;

/// The frame's blocks, in CPU memory.
typedef struct gl_frame {
    item_block* items;
    gl_placed* placed;
    size_t item_count, item_capacity, placed_capacity;
    record_block* records;
    size_t record_count, record_capacity;
    chunk_block* chunks;
    size_t chunk_count, chunk_capacity;
    uint32_t* lookup;
    size_t lookup_count, lookup_capacity;
    uint32_t id_shift;
    gl_commands commands[GL_COMMAND_KINDS];
    gl_ring ring; ///< for uploading all of it
    /// What shaders read: a copy of the ring's part in the GPU's own memory. Reading mapped memory
    /// for every vertex crosses the bus each time.
    GLuint buffer;
    uint64_t buffer_size;
    GLintptr items_offset, records_offset, chunks_offset, lookup_offset, view_offset;
    GLintptr groups_offset; ///< first group of each splat command, for the compute rasteriser
    uint64_t group_count;   ///< groups of all splat commands
    uint32_t missing;       ///< items coarser than the list wants, for all eyes
    uint32_t coming;        ///< uploads postponed to later frames
    bool beside;            ///< large triangles of the previous set are drawn
    uint64_t large_count;
    gl_cluster_shares shares;
    uint32_t* marks; ///< one bit per cluster of a mesh: it contains large triangles of the item
    size_t mark_capacity;
} gl_frame;

/// Bounds of an octave's splat positions, in grid units.
typedef struct gl_octave_box {
    uint16_t low[3], high[3];
    uint16_t largest; ///< code of the maximum radius (base/splats/splat_codes.h)
    bool replaced;    ///< large triangles replace some
} gl_octave_box;

/// First entries of each kind of data in the pool's table.
typedef struct gl_entries {
    uint32_t* sets;       ///< per surfel set: two per octave, positions and colours
    uint32_t meshes;      ///< one per item
    uint32_t textures;    ///< two per texture: read as colour, and as data
    uint32_t* point_sets; ///< one per chunk
    /// Boxes of uploaded octaves, indexed by half the number of their position entry
    gl_octave_box* boxes;
    uint32_t count;
} gl_entries;

/// Data read back from the GPU.
typedef struct gl_readback {
    float* depth;
    size_t capacity;
    bool has_depth; ///< `depth` holds the last picture's
} gl_readback;

/// CPU times of a picture's steps in milliseconds: see stp_draw_gl_stats.
typedef struct gl_clock {
    double prepare, issue, read;
} gl_clock;

/// Messages of a debug context.
typedef struct gl_debug {
    uint32_t errors;
    char message[400]; ///< the first error
} gl_debug;

/// Sum of frames of a view at rest.
typedef struct gl_accumulation {
    uint32_t frames; ///< summed frames; 0: none yet, or outdated
    uint32_t width, height;
    stp_resting resting; ///< inputs of those frames
} gl_accumulation;

struct gl_renderer {
    stp_renderer base;
    stp_gl gl;
    stp_store* store;
    const stp_store_directory* directory;
    bool is_software;
    char device[160];
    uint64_t upload_bytes; ///< per frame; 0: all
    gl_debug* debug;
    gl_pool pool;
    gl_entries entries;
    uint32_t program_pages; ///< page count of the programs; 0: no programs yet
    bool program_squares;   ///< programs draw splats as squares
    gl_splat_pass splats;
    gl_raster_pass raster;
    gl_splat_choice splat_choice;
    gl_filter_pass filter;
    gl_occlusion_pass occlusion;
    bool keeps_all;    ///< always a single pass, for comparison
    bool keeps_groups; ///< draws invisible groups too, for comparison
    bool unshaded;     ///< pictures end with the visibility buffer, for comparison
    gl_triangle_pass triangles;
    gl_shade_pass shade;
    gl_effect_pass effects;
    gl_cap_pass cap_pass;
    gl_layer_pass layer_pass;
    gl_timer timer;
    gl_target target;
    gl_frame frame;
    GLuint light_materials, materials; ///< constant storage buffers
    gl_readback* readback;
    gl_clock clock;
    gl_accumulation accumulation;
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
};

/// Defines for programs that read pages. @return `text`
const char* gl_page_defines(const gl_renderer* r, const char* more, char* text, size_t size);

/// Shaders of splats too large for points.
const char* gl_large_vertex_shader(const gl_renderer* r);
const char* gl_large_fragment_shader(const gl_renderer* r);
STP_MUST_USE stp_result gl_splat_pass_create(gl_renderer* r);
void gl_splat_pass_destroy(gl_renderer* r);
/// Clears the queue of large splats before splats are drawn.
void gl_splat_pass_begin(gl_renderer* r);
STP_MUST_USE stp_result gl_splat_pass_points(gl_renderer* r, const gl_splat_source* source,
                                             GLuint program);
/// Draws the queued large splats.
void gl_splat_pass_large(gl_renderer* r, GLuint program);
/// Sets the viewport and state for splats and triangles, and binds the view's framebuffer.
void gl_set_visible_state(gl_renderer* r);

STP_MUST_USE stp_result gl_triangle_pass_create(gl_renderer* r);
void gl_triangle_pass_destroy(gl_renderer* r);
STP_MUST_USE stp_result gl_triangle_pass_draw(gl_renderer* r);

// portions.c
/// Draws the commands of a kind, at `offset` of the bound buffer. @return STP_OK, or
/// STP_ERROR_CANCELLED (not logged) if the picture is cancelled (stp_renderer_set_stop)
STP_MUST_USE stp_result gl_portion_draw(gl_renderer* r, GLenum mode, const gl_commands* commands,
                                        GLintptr offset, GLintptr count_offset);
/// If the picture may be cancelled, waits for everything drawn so far. @return as gl_portion_draw
STP_MUST_USE stp_result gl_portion_wait(gl_renderer* r);

STP_MUST_USE stp_result gl_shade_pass_create(gl_renderer* r);
void gl_shade_pass_destroy(gl_renderer* r);
/// Draws one sample into the picture or the sums. @return as gl_program_create
STP_MUST_USE stp_result gl_shade_pass_draw(gl_renderer* r, bool sums);
/// Adds the picture to the sums. @return as gl_program_create
STP_MUST_USE stp_result gl_shade_pass_add(gl_renderer* r);
/// Resolves the sums into the picture. @return as gl_program_create
STP_MUST_USE stp_result gl_shade_pass_average(gl_renderer* r);
/// Sets all counters to 0.
void gl_shade_pass_clear(gl_renderer* r);
/// Waits for the GPU. @return a counter since the reset
uint32_t gl_shade_pass_read(gl_renderer* r, gl_counter counter);

/// Creates textures and framebuffer of the view's size. @return STP_OK, STP_ERROR_LIMIT,
/// STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result gl_target_make(gl_renderer* r, const stp_view* view, bool sums);
void gl_target_destroy(gl_renderer* r);
/// Runs a compute program of GROUP_SIDE x GROUP_SIDE pixels a group over a picture.
void gl_dispatch_pixels(gl_renderer* r, GLuint program, uint32_t width, uint32_t height);
GLuint gl_make_texture(const stp_gl* gl, GLenum format, uint32_t width, uint32_t height,
                       const char* label);
/// Reads a texture of four bytes per pixel, in bands of whole rows of at most `band_bytes`, or one
/// row. Waits.
void gl_read_texture(const stp_gl* gl, GLuint texture, GLenum format, GLenum type, uint32_t width,
                     uint32_t height, uint64_t band_bytes, void* pixels);

/// Uploads the list's data to the pool, within the frame's upload limit, and builds blocks, records
/// and commands. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, or as the store's functions; logged
STP_MUST_USE stp_result gl_frame_make(gl_renderer* r);
/// Places items again after the placement's shift has changed; `pattern` is the sample's number.
void gl_frame_place(gl_renderer* r, uint32_t pattern);
/// Uploads everything to the GPU, and binds it.
STP_MUST_USE stp_result gl_frame_send(gl_renderer* r, const view_block* view);
void gl_frame_destroy(gl_renderer* r);
/// Appends a command of a kind, with a record. @return the record; NULL if out of memory
record_block* gl_frame_add_command(gl_renderer* r, gl_command_kind kind, uint32_t count);
/// Appends another command for the last record. @return false if out of memory
bool gl_frame_repeat_command(gl_renderer* r, gl_command_kind kind, uint32_t count);
/// Appends a chunk of an item's splats. NULL if out of memory.
chunk_block* gl_frame_add_chunk(gl_renderer* r, item_block* item);

/// Samples of a picture, each drawn separately.
typedef struct gl_sample_range {
    uint32_t side, first, end; ///< samples [first, end) of side x side
    bool sums;                 ///< the picture is their mean, including those before `first`
    bool bytes;                ///< each is resolved to a picture first, for post-processing
    bool scattered;            ///< consecutive samples lie far apart
} gl_sample_range;

/// Draws samples of an eye's picture. @return result of the first failing step
STP_MUST_USE stp_result gl_draw_eye(gl_renderer* r, uint32_t eye, const gl_sample_range* range);
/// Restores the context state that draw_gl.h promises.
void gl_leave_state(const gl_renderer* r);
/// Creates programs for the current number of pages and the style's shape of splats. @return as
/// gl_program_create
STP_MUST_USE stp_result gl_make_programs(gl_renderer* r);

/// Uploads the store's materials, once. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_materials_create(gl_renderer* r);

/// Binds the inputs of all passes over pixels and splats.
void gl_bind_frame(gl_renderer* r);
