// SPDX-License-Identifier: MIT
// Definitions shared by C and GLSL: bindings, sizes and buffer layouts (storage buffers std430,
// uniform buffers std140; the C structs have the same layout). A word's address has the page number
// in its high bits and the offset within the page below.

// Storage buffers. Pages are 0 to 7.
#define BINDING_PAGES 0
#define BINDING_ITEMS 8
#define BINDING_RECORDS 9
#define BINDING_CHUNKS 10
#define BINDING_LARGE 11 // splats too large for a point: see large_block
// item of each id: ID_TABLE + 2 words, then the first ids of items
#define BINDING_LOOKUP 12
#define BINDING_LIGHT_MATERIALS 13
#define BINDING_MATERIALS 14
#define BINDING_COUNTERS 15
// For the compute rasteriser and one-pass blending, whose programs read nothing else there.
#define BINDING_RASTER_PIXELS 12
#define BINDING_RASTER_COMMANDS 13
#define BINDING_RASTER_GROUPS 14
// For occlusion culling.
#define BINDING_PYRAMID 12
#define BINDING_OCCLUDED_COMMANDS 13
// Uniform buffers.
#define BINDING_VIEW 0
#define BINDING_EFFECTS 1
#define BINDING_NOISE 2 // blue noise: two ranks per word
// Texture units and image units.
#define UNIT_IDS 0
#define UNIT_NEARNESS 1
#define UNIT_FROM 2   // inputs of passes over a picture
#define UNIT_BLOCKS 3 // minimum nearness of each block
#define UNIT_PLANES 4
#define UNIT_BLENDED 5
#define UNIT_BEFORE_IDS 6 // ids of the previous layer
#define UNIT_BEFORE_NEARNESS 7
#define UNIT_BELOW 8
#define UNIT_CAPS 9 // nearness of section caps
#define UNIT_SPLAT_TEXTURE 10
#define IMAGE_PICTURE 0
#define IMAGE_DEPTH 1
#define IMAGE_SUMS 2
#define IMAGE_PLANE 3
#define IMAGE_PLANES 4
#define IMAGE_LIGHT 5 // colour of the layers so far, and their transmittance
#define IMAGE_BELOW 6
#define IMAGE_OPTICAL 7 // optical depths of all triangles
#define IMAGE_KINDS 3   // what pixels show, while they are shaded

#define GROUP_SIDE 8 // size of a compute group over pixels
#define LOCK_TRIES 65536
#define RASTER_GROUP 64  // splats per compute group
#define RASTER_ALONE 64  // maximum pixels of a splat's box for one thread
#define OCCLUDE_GROUP 64 // commands per compute group
#define PYRAMID_BLOCK 8  // side of a level 0 block in pixels; blocks of the next levels are 2 x 2
#define PYRAMID_SHIFT 3
#define PYRAMID_LEVELS 4
#define ID_TABLE 16384
#define NO_ID 0xFFFFFFFFu
#define NO_ADDRESS 0xFFFFFFFFu
// pixels: splats that extend farther from their centre's pixel are drawn as two triangles
#define POINT_EXTENT 60
#define LARGE_MAX 262144
#define SHADINGS 256
#define SRGB_STEPS 16384 // linear values are truncated to such steps before encoding

// Kinds of items (stp_draw_kind).
#define KIND_SPLATS 0u
#define KIND_MESH 1u
#define KIND_POINTS 2u

// Filters of overlapping splats (stp_filter).
#define FILTER_NONE 0u
#define FILTER_EWA 1u
#define FILTER_BLEND 2u
#define FILTER_TEXTURED 3u

// Colouring of pixels (stp_draw_coloring).
#define RECOLORS_NOT 0u
#define RECOLORS_HEIGHT 1u
#define RECOLORS_NORMAL 2u
#define SCALE_COLORS 256

// Position of a culled point: outside the clip volume.
#define HIDDEN_PLACE 1e30

// Flags of items.
#define ITEM_FACING 1u             // disks face the eye
#define ITEM_HAS_COLORS 2u         // its vertices or points have colours
#define ITEM_HAS_NORMALS 4u        // its points have normals
#define ITEM_GHOST 8u              // drawn in a share of its pixels
#define ITEM_SHAPES 16u            // splats have individual radii
#define ITEM_RANGES 32u            // splats are drawn within ranges of levels
#define ITEM_BESIDE 64u            // omits splats that large triangles replace
#define ITEM_LARGE 128u            // omits triangles with too low a level
#define ITEM_FIXED 256u            // fixed-size points, drawn in full
#define ITEM_SIDELESS 512u         // its splats do not tell which of their sides is seen
#define ITEM_GROWTHS 1024u         // splats have radii by their shadings
#define ITEM_ERRORS 2048u          // the view direction lowers the levels of ranges
#define SHAPE_REPLACED 0x80000000u // bit of a disk's shape: large triangles replace it
#define SECTION_PLANES 14
#define GHOST_SEED 0x6057u // independent of the pixels that alpha removes

// Radii in codes of shapes, and shares in codes of errors (base/splats/splat_codes.h).
#define SHAPE_BIAS 0x3E800000u
#define ERROR_SHARE_FIRST 5u
#define ERROR_STEPS 20.0

// Alpha of materials (stp_store_alpha).
#define ALPHA_OPAQUE 0u
#define ALPHA_MASK 1u
#define ALPHA_BLEND 2u

// Which splats are left out where they face away (stp_front_only), by more than this sine.
#define FRONT_ONLY_NONE 0u
#define FRONT_ONLY_SOME 1u
#define FRONT_ONLY_ALL 2u
#define BACK_SINE 0.25

// Drawing of transparent surfaces: by alpha thresholds, or not at all if layers follow.
#define GLASS_PATTERN 0u
#define GLASS_LAYERS 1u
#define NOISE_SIDE 64
#define GLASS_RIM_DEPTH 1.0
#define GLASS_BACK_DEPTH 0.5
#define GLASS_THICKNESS 3.0
#define GLASS_CELL_SHIFT 10
#define GLASS_CELLS 64.0
#define ALPHA_OPAQUE_FROM (254.5 / 255.0)
#define ALPHA_MIN (0.5 / 255.0)
#define LAYERS_CLEAR (1.0 / 1024.0)
#define OPTICAL_UNIT 4096 // of optical depths (draw/transparency.h)

// Header of a triangle cluster, at the beginning of its mesh, in words. Offsets are relative to the
// mesh's address.
#define CLUSTER_WORDS 16
#define CLUSTER_FIRST_TRIANGLE 0
#define CLUSTER_TRIANGLE_COUNT 1
#define CLUSTER_TRIANGLES 2 // one word each: three corners of ten bits, and the kind of normal
#define CLUSTER_POSITIONS 3 // three floats per vertex
#define CLUSTER_NORMALS 4   // one word per normal: octahedral, 16 bits each
#define CLUSTER_TEXCOORDS 5 // two floats per vertex; and 6: of the second set. 0: none
#define CLUSTER_COLORS 7    // two words per vertex: linear, 16 bits each. 0: none
#define CLUSTER_BOX 8       // six floats
#define TRIANGLE_PLAIN 0u   // its plane's normal
#define TRIANGLE_FACE 1u    // its first corner's
#define TRIANGLE_SMOOTH 2u

// Header of a texture: flags, levels, then for each level width, height and the offset of its
// texels from the texture's address.
#define TEXTURE_FLAGS 0
#define TEXTURE_LEVELS 1
#define TEXTURE_SIZES 2
#define TEXTURE_HEADER 52
#define TEXTURE_LINEAR 1u
#define TEXTURE_NEAREST 2u
#define TEXTURE_WRAP_U 4u // multiplied by 0 repeat, 1 clamp, 2 mirror
#define TEXTURE_WRAP_V 16u
#define TEXTURE_CUTOUT 64u // after the texels: TEXTURE_CUTOFFS floats for each level that has them
#define TEXTURE_REDUCED 128u // level 0 is not the image's full resolution
#define TEXTURE_CUTOFFS 256
#define TEXTURE_CUTOFF_SHIFT 8 // from this bit of the flags: levels with cutoffs

#ifdef __STDC_VERSION__
typedef float vec4[4];
typedef uint32_t uvec4[4];
typedef uint32_t uint;
#endif

// An item and its placement. Rows map to the screen: X, Y (pixels, times W), N (nearness, times W),
// W; from grid positions for splats, from positions minus `offset` for meshes.
struct item_block {
    vec4 rows[4];
    vec4 turn[3];                                       // view rotation of splats' normals
    vec4 normal[3];                                     // normals to the scene
    vec4 offset;                                        // meshes: subtracted from positions
    float radius_px, center_x, center_y, inverse_scale; // see src/raster/splats_kernel.h
    float slope_factor, slope_constant, rim_depth, back_depth;
    float near_w, far_w, glass_cells, nearness_limit; // cells of a transparent mesh per unit
    float near_factor, near_shift; // true nearness = factor * that of the buffer + shift
    float footprint;               // item units per pixel at depth 1
    float blend;                   // share of `colors` below low_count
    uint kind, flags, seed, first_id;
    uint count, material, first_chunk, chunk_count;
    uint colors, low_colors, low_count, address; // addresses; a count; meshes: their address
    uint cluster_count, base_color, metallic_roughness, emissive; // a count; texture addresses
    uint sections;          // bits of section planes that may cut it
    float section_slack;    // splats: maximum rounding beyond a section plane, in scene units
    float glass_radius;     // splats: radius in scene units
    float level_per_depth;  // level compared with ranges: this times the depth, at least level_min
    vec4 box_low, box_high; // box of drawn splats, in the rows' input space
    float level_min;        // minimum level
    float large_from;       // large triangles: minimum depth of the nearest corner
    float level_below;      // level of splats before `divide`, at any depth
    uint divide;
    float pixels; // added to the radius on the screen
    float eye[3]; // levels: in the mesh's space, less `offset`; in parallel, direction towards it;
                  // splats with errors: in grid coordinates; in parallel, the view direction
    float growth_share;      // splats: radii are multiplied by 1 + growth of the shading * this
    uint normal_map;         // address of a texture
    uint lights, low_lights; // addresses of light normals, likewise to `colors`; NO_ADDRESS: none
};

// One command of a multi-draw, or a part of it: splats, or a cluster.
struct record_block {
    uint item;
    uint first;   // splats: index of the first in the item; clusters: number of one-sided triangles
    uint address; // address of the first splat, or of the cluster
    float share;  // drawn share of a cluster's triangles; ITEM_GROWTHS: byte of the first material
    float nearest, farthest; // splats: within these depths (W)
    float reach;             // splats: maximum radius, relative to the item's
    uint options; // splats: address of the first splat's shape, range and errors, or material
};

// A chunk: consecutive splats of an item, from the previous chunk's end to `end`.
struct chunk_block {
    uint begin, end, address, spare;
};

// Lighting parameters of a material.
struct light_material_block {
    vec4 surface;  // metallic, rough, a^2, gloss
    vec4 emissive; // and whether it is unlit
};

struct material_block {
    vec4 base_color;
    vec4 numbers;  // metallic, roughness, alpha cutoff, alpha mode
    vec4 emissive; // and whether it is unlit
    // for base colour, metallic and roughness, emissive, normals: two rows of a transform, the first
    // with the set of texture coordinates as fourth; the last with the scale of normals as fourth
    vec4 uses[8];
};

struct view_block {
    vec4 size;  // width, height, 1 / width of the viewport, 1 / height of the viewport
    vec4 light; // towards the key light
    vec4 up;    // up direction of the scene
    vec4 left_box, right_box; // towards soft boxes
    vec4 eye_start, eye_across,
        eye_down; // towards the eye from a pixel, not normalized; across and down are 0 in parallel
    vec4 background; // linear, and whether it is drawn
    float nearness_scale, margin;
    uint parallel, pattern;                                 // index of the sample, for hashed alpha
    uint item_count, id_shift, sample_number, sample_count; // samples before, and including it
    float point_extent;
    float ghost,
        ghost_splats; // drawn share of a ghost's pixels: of triangles, and of each disk
    float nearness_offset;
    uint picture_x, depth_y; // origin of this eye's picture and depths
    // whether shading writes the final picture: counts its pixels, draws the background
    uint counts;
    uint filtered;   // a FILTER
    uint ghost_seed; // GHOST_SEED as a variable: Mesa 22.3 folds products of constants wrongly
    uint glass;      // a GLASS
    uint hides;      // whether splats of coverage 0 are not drawn
    uint recolors;   // a RECOLORS
    uvec4 glass_shadings[2]; // one bit per shading: transparent
    uvec4 front_shadings[2]; // one bit per shading: drawn from the front only
    vec4 screen;             // principal point, 1 / pixels per unit of x/z (or per unit)
    vec4 section_rows
        [SECTION_PLANES]; // in right, down, depth: positions with a sum above 0 are cut away
    vec4 earlier[4];      // from X, Y, true N, W to those of the picture with known depths
    float corner;         // distance over depth in a corner of the picture
    uint scale_first;     // start of the colour scale among the lighting materials
    uint front_only;      // a FRONT_ONLY
    uint nearest_only;    // whether the nearest layer stands for all
    vec4 height_place, height_along; // src/draw/shading_setup.h
    vec4 growths[SHADINGS / 4];      // of the shadings, if items have ITEM_GROWTHS
};

// Post-shading effects (draw/effect_shape.h).
#define EFFECT_PAIRS 64
#define EFFECT_BLOCK 8 // pixels a side
struct effect_block {
    // gain, whether it is constant, strength of eye-dome lighting, share of a pair's occlusion
    vec4 numbers;
    uint pair_count, light_step, spare0, spare1;
    // x, y, whether to read from blocks; then 1 / distance, bias, 1 / reach
    vec4 pairs[2 * EFFECT_PAIRS];
};

// A pixel for blending splats in one pass.
#define TOLERANT_TINY 0x7C007C00u  // slopes of a one-pixel splat, which has none: two infinities
#define TOLERANT_TAKEN 0xFFFFFFFFu // slopes of a locked pixel
struct tolerant_pixel {
    uint slopes;      // slopes of its plane, two halves; also its lock
    float key, plane; // nearness for ordering; nearness of its plane. 0: empty
    uint id;
    vec4 sum; // weighted colour, weight
};

#ifdef __STDC_VERSION__
typedef struct tolerant_pixel tolerant_pixel;
typedef struct effect_block effect_block;
typedef struct item_block item_block;
typedef struct record_block record_block;
typedef struct chunk_block chunk_block;
typedef struct light_material_block light_material_block;
typedef struct material_block material_block;
typedef struct view_block view_block;
/// Queue of large splats, from the point pass to the large pass: the command that draws them, and
/// each splat's record and index in it.
typedef struct large_block {
    uint32_t vertex_count, instance_count, first, base;
    uint32_t places[LARGE_MAX][2];
} large_block;
_Static_assert(sizeof(item_block) == 400, "layout of items");
_Static_assert(sizeof(record_block) == 32, "layout of records");
_Static_assert(sizeof(material_block) == 176, "layout of materials");
_Static_assert(sizeof(effect_block) == 32 + 32 * EFFECT_PAIRS, "layout of effects");
_Static_assert(sizeof(view_block) == 1664, "layout of the view");
#endif
