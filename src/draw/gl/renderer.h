// SPDX-License-Identifier: MIT
//
// The OpenGL backend. A frame is:
//
//   items     what the list holds is brought to the pool (upload.h), and becomes blocks that shaders read (items.h)
//   drawn     splats as points, those too large for that as quads, triangles: one command each, into the visibility buffer;
//             splats and triangles twice: first what the picture before does not hide (occlusion_pass.h)
//   shaded    a compute pass looks up what each pixel's id is, and lights it; effects and averages after it
//
// Each pass is a file with create, draw and destroy, and owns its program; programs depend on how many pages the pool has
// and on the shape of splats, and are made anew where that changes.
#pragma once

#include "draw/gl/cap_pass.h"
#include "draw/gl/effect_pass.h"
#include "draw/gl/filter_pass.h"
#include "draw/gl/gl.h"
#include "draw/gl/layer_pass.h"
#include "draw/gl/occlusion_pass.h"
#include "draw/gl/pool.h"
#include "draw/gl/program.h"
#include "draw/gl/raster_pass.h"
#include "draw/gl/splat_choice.h"
#include "draw/gl/timer.h"
#include "draw/placement.h"
#include "draw/renderer.h"
#include "draw/resting.h"
#include "draw/shaders/interface.h"
#include "store/clusters.h"

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
    GLuint shade, sums, average, add; ///< those beside the first are made when they are needed
    GLuint counters;                  ///< covered pixels
} gl_shade_pass;

/// What pictures are drawn into. Sizes are those of the last picture.
typedef struct gl_target {
    uint32_t width, height; ///< of what an eye sees
    uint32_t eye_count;
    uint32_t full_width;               ///< of the picture: its last column may be no eye's
    GLuint ids, nearness, framebuffer; ///< of an eye
    GLuint picture;                    ///< RGBA8: the eyes' side by side
    GLuint depths;                     ///< R32F: true nearness, one eye's above the other's
    GLuint sums;                       ///< RGBA32F, as the picture; 0: not needed yet
} gl_target;

/// Commands of one multi-draw, and where they lie in this frame's part of the ring.
typedef struct gl_commands {
    struct gl_command {
        uint32_t count, instance_count, first, base;
    } * commands;
    size_t count, capacity;
    GLintptr offset, count_offset;
} gl_commands;

typedef enum gl_command_kind {
    GL_COMMANDS_SPLATS,
    GL_COMMANDS_TRIANGLES,
    GL_COMMANDS_KEEP,                              ///< triangles whose fragments are looked at
    GL_COMMANDS_CULLED,                            ///< those above may be hidden
    GL_COMMANDS_GLASS_SPLATS = GL_COMMANDS_CULLED, ///< for layers: what may be transparent
    GL_COMMANDS_GLASS_TRIANGLES,
    GL_COMMAND_KINDS
} gl_command_kind;

/// What of an item outlives the making of its block: to place it anew for each sample.
typedef struct gl_placed {
    const stp_draw_item* draw;
    float offset[3];
    float radius;    ///< of splats, item space; of those with shapes, a step of their set
    float scale;     ///< what radii are multiplied by
    stp_vec3 origin; ///< of surfels' grid
    float step;
    bool unknown_signs; ///< of surfels' normals
} gl_placed;

/// The frame's blocks, in the processor's memory.
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
    gl_ring ring; ///< that all of it goes through
    GLintptr items_offset, records_offset, chunks_offset, lookup_offset, view_offset;
    uint32_t missing; ///< things that are coarser than the list wants, of all eyes
    uint32_t coming;  ///< uploads that were put off to later frames
    bool beside;      ///< large triangles of the set before are drawn
    uint64_t large_count;
    uint32_t* marks; ///< of clusters that have some: a bit each
    size_t mark_capacity;
} gl_frame;

/// What holds the places of an octave's splats, in numbers of the grid.
typedef struct gl_octave_box {
    uint16_t low[3], high[3];
    uint16_t largest; ///< code of the largest radius (base/splat_codes.h)
    bool replaced;    ///< large triangles replace some
} gl_octave_box;

/// Where things' entries begin in the pool's table.
typedef struct gl_things {
    uint32_t* sets;       ///< of each surfel set: two an octave, places and colours
    uint32_t meshes;      ///< one each
    uint32_t textures;    ///< two each: read as colour, and as data
    uint32_t* point_sets; ///< one for each chunk
    gl_octave_box*
        boxes; ///< of octaves that were brought: at half the number of their places' entries
    uint32_t count;
} gl_things;

/// What was brought back from the graphics processor.
typedef struct gl_readback {
    float* depth;
    size_t capacity;
    bool has_depth; ///< of the last picture
} gl_readback;

/// What a debug context says.
typedef struct gl_debug {
    uint32_t errors;
    char message[400]; ///< the first error
} gl_debug;

/// The sum of frames of a view that rests.
typedef struct gl_accumulation {
    uint32_t frames; ///< summed; 0: none yet, or no longer of any use
    uint32_t width, height;
    stp_resting resting; ///< what they are of
} gl_accumulation;

struct gl_renderer {
    stp_renderer base;
    stp_gl gl;
    stp_store* store;
    const stp_store_directory* directory;
    bool is_software;
    char device[160];
    uint64_t upload_bytes; ///< of a frame; 0: all
    gl_debug* debug;
    gl_pool pool;
    gl_things things;
    uint32_t program_pages; ///< pages that the programs are made for; 0: there are none
    bool program_squares;   ///< that they draw splats as squares
    gl_splat_pass splats;
    gl_raster_pass raster;
    gl_splat_choice splat_choice;
    gl_filter_pass filter;
    gl_occlusion_pass occlusion;
    bool keeps_all;    ///< one pass always, for comparison
    bool keeps_groups; ///< groups that cannot be seen too, for comparison
    bool unshaded;     ///< pictures end with the visibility buffer, for comparison
    gl_triangle_pass triangles;
    gl_shade_pass shade;
    gl_effect_pass effects;
    gl_cap_pass cap_pass;
    gl_layer_pass layer_pass;
    gl_timer timer;
    gl_target target;
    gl_frame frame;
    GLuint light_materials, materials; ///< storage buffers that never change
    gl_readback* readback;
    gl_accumulation accumulation;
    float point_extent; ///< most pixels from a point's middle to its rim
    // this picture
    stp_placement placement;
    uint32_t eye;
    const stp_view* view;             ///< of all eyes
    const stp_visibility* visibility; ///< NULL: all is shown
    const stp_draw_style* style;
    const stp_draw_list* list;
    stp_result failure;              ///< why an upload failed
    uint32_t draw_calls, dispatches; ///< of the last picture's last sample
    uint32_t counted_samples;        ///< that the last call drew
};

/// Defines for programs that read pages. @return `text`
const char* gl_page_defines(const gl_renderer* r, const char* more, char* text, size_t size);

/// The shaders of splats that no point holds.
const char* gl_large_vertex_shader(const gl_renderer* r);
const char* gl_large_fragment_shader(const gl_renderer* r);
STP_MUST_USE stp_result gl_splat_pass_create(gl_renderer* r);
void gl_splat_pass_destroy(gl_renderer* r);
/// Before a way of drawing splats: no large ones are noted yet.
void gl_splat_pass_begin(gl_renderer* r);
STP_MUST_USE stp_result gl_splat_pass_points(gl_renderer* r, const gl_splat_source* source,
                                             GLuint program);
/// What was noted as too large.
void gl_splat_pass_large(gl_renderer* r, GLuint program);
/// The viewport and state that splats and triangles are drawn with, and the view's framebuffer.
void gl_set_visible_state(gl_renderer* r);

STP_MUST_USE stp_result gl_triangle_pass_create(gl_renderer* r);
void gl_triangle_pass_destroy(gl_renderer* r);
STP_MUST_USE stp_result gl_triangle_pass_draw(gl_renderer* r);

// portions.c
/// Draws the commands of a kind, which lie at `offset` of the bound buffer. @return STP_OK, or STP_ERROR_CANCELLED (not logged)
/// where the picture is abandoned (stp_renderer_set_stop)
STP_MUST_USE stp_result gl_portion_draw(gl_renderer* r, GLenum mode, const gl_commands* commands,
                                        GLintptr offset, GLintptr count_offset);
/// Waits for what was drawn so far, where the picture may be abandoned. @return as gl_portion_draw
STP_MUST_USE stp_result gl_portion_wait(gl_renderer* r);

STP_MUST_USE stp_result gl_shade_pass_create(gl_renderer* r);
void gl_shade_pass_destroy(gl_renderer* r);
/// One sample: into the picture, or into the sums. @return as gl_program_create
STP_MUST_USE stp_result gl_shade_pass_draw(gl_renderer* r, bool sums);
/// Adds the picture to the sums. @return as gl_program_create
STP_MUST_USE stp_result gl_shade_pass_add(gl_renderer* r);
/// The picture from the sums. @return as gl_program_create
STP_MUST_USE stp_result gl_shade_pass_average(gl_renderer* r);
/// Forgets what was counted.
void gl_shade_pass_clear(gl_renderer* r);
/// Waits. @return pixels covered since then
uint32_t gl_shade_pass_covered(gl_renderer* r);

/// Textures and framebuffer of the size of the view. @return STP_OK, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result gl_target_make(gl_renderer* r, const stp_view* view, bool sums);
void gl_target_destroy(gl_renderer* r);
GLuint gl_make_texture(const stp_gl* gl, GLenum format, uint32_t width, uint32_t height,
                       const char* label);
/// Reads a texture of four bytes a pixel, in bands of whole rows of at most `band_bytes`, or one row. Waits.
void gl_read_texture(const stp_gl* gl, GLuint texture, GLenum format, GLenum type, uint32_t width,
                     uint32_t height, uint64_t band_bytes, void* pixels);

/// Brings what the list holds to the pool, as far as the frame's uploads allow, and makes blocks, records and commands of
/// it. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, or as the store's functions; logged
STP_MUST_USE stp_result gl_frame_make(gl_renderer* r);
/// Places items anew after the placement's shift has changed; `pattern` is the sample's number.
void gl_frame_place(gl_renderer* r, uint32_t pattern);
/// Hands all to the graphics processor, and binds it.
STP_MUST_USE stp_result gl_frame_send(gl_renderer* r, const view_block* view);
void gl_frame_destroy(gl_renderer* r);
/// Room for one more command of a kind and a record for it. @return the record; NULL where memory runs out
record_block* gl_frame_add_command(gl_renderer* r, gl_command_kind kind, uint32_t count);
/// Another command for the last record. @return false where memory runs out
bool gl_frame_repeat_command(gl_renderer* r, gl_command_kind kind, uint32_t count);
/// Appends a chunk of an item's splats. NULL where memory runs out.
chunk_block* gl_frame_add_chunk(gl_renderer* r, item_block* item);

/// Samples of a picture that are drawn, each by itself.
typedef struct gl_sample_range {
    uint32_t side, first, end; ///< of side x side
    bool sums;                 ///< the picture is their mean, with those before `first`
    bool bytes;                ///< each is made a picture first: something is done with it
    bool scattered;            ///< neighbours in time lie far apart
} gl_sample_range;

/// Draws samples of what an eye sees. @return as what is called
STP_MUST_USE stp_result gl_draw_eye(gl_renderer* r, uint32_t eye, const gl_sample_range* range);
/// What draw_gl.h promises of the context's state.
void gl_leave_state(const gl_renderer* r);
/// Programs for as many pages as there are. @return as gl_program_create
STP_MUST_USE stp_result gl_make_programs(gl_renderer* r);

/// Materials of the store, once. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result gl_materials_create(gl_renderer* r);

/// Binds what all passes over pixels and splats read.
void gl_bind_frame(gl_renderer* r);
