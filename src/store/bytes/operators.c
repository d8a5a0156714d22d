// SPDX-License-Identifier: MIT
#include "store/bytes/operators.h"

#include "base/splats/splat_codes.h"
#include "store/bytes/range_coder.h"

#include <assert.h>
#include <float.h>
#include <math.h>

/// What predicts a splat; also selects its models.
typedef enum kind {
    KIND_BASE,   ///< the splat before it
    KIND_FIRST,  ///< its parent
    KIND_SECOND, ///< its parent and the first child
    KINDS
} kind;

enum {
    CLASSES = 17, ///< classes of numbers by the bits of their magnitude, 0 to 16
    CLASS_BITS = 5,
    LEARNT = 2,     ///< modelled bits after the leading one
    LEAVES = KINDS, ///< offset of the models of leaves
    /// Contexts: kinds; second children by how much the first one differs, 0 to 8 bits.
    CHANGES = KIND_SECOND + 9,
    SHARE_MAX = 16,
    COLOR_WHOLE = 255,
};

/// Models of a signed number.
typedef struct number_model {
    stp_bit_model tree[1 << CLASS_BITS]; ///< for the bits of the class, highest first
    stp_bit_model negative[CLASSES];
    stp_bit_model upper[CLASSES][1 << LEARNT];
} number_model;

typedef struct models {
    stp_bit_model is_base, is_leaf[KINDS], is_same_leaf[KINDS], is_disk[2 * KINDS];
    stp_bit_model coverage[2][256];
    number_model larger[2 * KINDS], stretch[2 * KINDS], direction[2 * KINDS];
    number_model material[KINDS], lowest[KINDS], highest[KINDS];
    number_model along[KINDS], across[KINDS]; ///< positions in the parent's plane and out of it
    number_model normal[CHANGES], green[CHANGES], other_colors[CHANGES];
} models;

typedef struct splat {
    int32_t position[3], normal[2], color[3];
    uint32_t material, coverage, shape, range;
} splat;

typedef struct codec {
    stp_range_coder coder;
    const stp_splats* set;
    uint32_t leaf_shape; ///< shape of the previous leaf
    bool failed;         ///< decoding: the input is invalid
    models models;
} codec;

/// The prediction context of a splat.
typedef struct context {
    kind kind;
    splat parent; ///< the splat it replaces; for a base splat, the previous one
    splat first;  ///< only for second children: the first child
} context;

static splat load(const stp_splats* s, uint32_t index)
{
    size_t i = index;
    splat made = {.material = s->materials[i],
                  .coverage = s->coverages[i],
                  .shape = s->shapes[i],
                  .range = s->ranges[i],
                  .normal = {s->normals[2 * i], s->normals[2 * i + 1]}};
    for (size_t k = 0; k < 3; ++k) {
        made.position[k] = s->positions[3 * i + k];
        made.color[k] = s->colors[3 * i + k];
    }
    return made;
}

static void store(const stp_splats* s, uint32_t index, const splat* from)
{
    size_t i = index;
    s->materials[i] = (uint8_t)from->material;
    s->coverages[i] = (uint8_t)from->coverage;
    s->shapes[i] = from->shape;
    s->ranges[i] = from->range;
    s->normals[2 * i] = (int8_t)from->normal[0];
    s->normals[2 * i + 1] = (int8_t)from->normal[1];
    for (size_t k = 0; k < 3; ++k) {
        s->positions[3 * i + k] = (uint16_t)from->position[k];
        s->colors[3 * i + k] = (uint8_t)from->color[k];
    }
}

static uint32_t magnitude_of(int32_t value)
{
    return (uint32_t)(value < 0 ? -value : value);
}

/// Number of bits of a magnitude.
static uint32_t class_of(uint32_t magnitude)
{
    uint32_t bits = 0;
    for (; magnitude != 0; magnitude >>= 1) {
        bits += 1;
    }
    return bits;
}

static bool code_flag(codec* c, stp_bit_model* model, bool value)
{
    return stp_range_code_bit(&c->coder, model, value ? 1 : 0) != 0;
}

/// Codes a number of `count` bits as a path in a binary tree of models; the root is model[1].
static uint32_t code_tree(codec* c, stp_bit_model* model, uint32_t count, uint32_t value)
{
    assert(count < 32 && value >> count == 0);
    uint32_t node = 1;
    for (uint32_t i = count; i-- > 0;) {
        node = node << 1 | stp_range_code_bit(&c->coder, &model[node], value >> i & 1u);
    }
    return node - (1u << count);
}

/// Codes a number from -65535 to 65535: class of the magnitude, sign, bits after the leading one.
static int32_t code_number(codec* c, number_model* m, int32_t value)
{
    uint32_t magnitude = magnitude_of(value);
    assert(magnitude <= UINT16_MAX);
    uint32_t bits = code_tree(c, m->tree, CLASS_BITS, class_of(magnitude)), made = 1;
    if (bits == 0 || bits >= CLASSES) {
        c->failed = c->failed || bits != 0;
        return 0;
    }
    bool negative = stp_range_code_bit(&c->coder, &m->negative[bits], value < 0 ? 1u : 0u) != 0;
    uint32_t learnt = bits > LEARNT ? (uint32_t)LEARNT : bits - 1, left = bits - 1 - learnt;
    for (uint32_t i = 0; i < learnt; ++i) {
        uint32_t bit = magnitude >> (bits - 2 - i) & 1u;
        made = made << 1 | stp_range_code_bit(&c->coder, &m->upper[bits][made], bit);
    }
    made = made << left | stp_range_code_plain(&c->coder, left, magnitude & ((1u << left) - 1u));
    return negative ? -(int32_t)made : (int32_t)made;
}

/// Codes a number of `width` bits as its difference from another one, modulo 2^width.
static uint32_t code_difference(codec* c, number_model* m, uint32_t width, uint32_t from,
                                uint32_t value)
{
    assert(width >= 1 && width <= 16);
    uint32_t mask = (1u << width) - 1u, half = 1u << (width - 1);
    uint32_t difference = (value - from) & mask;
    int32_t number = (int32_t)difference - (difference >= half ? (int32_t)mask + 1 : 0);
    return (from + (uint32_t)code_number(c, m, number)) & mask;
}

static double area_of(uint32_t shape)
{
    return (double)stp_shape_radius(shape & 0xFFFu) *
           (double)stp_shape_radius(shape >> 12 & 0xFFFu);
}

static int32_t round_within(double value, int32_t low, int32_t high)
{
    return value <= (double)low ? low : value >= (double)high ? high : (int32_t)floor(value + 0.5);
}

/// The second child's value for which the area-weighted mean of both children is the parent's.
static double find_opposite(int32_t parent, int32_t first, double share)
{
    return (double)parent + (double)(parent - first) * share;
}

static void code_shape(codec* c, const context* x, bool leaf, splat* s)
{
    uint32_t at = (uint32_t)x->kind + (leaf ? LEAVES : 0), shape = s->shape;
    if (leaf && code_flag(c, &c->models.is_same_leaf[x->kind], shape == c->leaf_shape)) {
        s->shape = c->leaf_shape;
        return;
    }
    uint32_t larger = shape & 0xFFFu, smaller = shape >> 12 & 0xFFFu, before = x->parent.shape;
    larger = code_difference(c, &c->models.larger[at], 12, before & 0xFFFu, larger);
    if (code_flag(c, &c->models.is_disk[at], smaller == (shape & 0xFFFu))) {
        smaller = larger;
    } else {
        smaller =
            (larger - code_difference(c, &c->models.stretch[at], 12, 0, larger - smaller)) & 0xFFFu;
    }
    uint32_t direction = code_difference(c, &c->models.direction[at], 8, before >> 24, shape >> 24);
    s->shape = larger | smaller << 12 | direction << 24;
    c->leaf_shape = leaf ? s->shape : c->leaf_shape;
}

/// Predicts the code of the highest level: levels rise from the parent's at the maximum slope.
static uint32_t predict_highest(const codec* c, const splat* parent, const splat* s)
{
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        double d = (double)(s->position[k] - parent->position[k]);
        sum += d * d;
    }
    double level = (double)stp_range_level(parent->range & 0xFFFFu) +
                   (double)STP_LEVEL_SLOPE * ((double)c->set->step * sqrt(sum));
    return stp_range_code(0.0f, level < (double)FLT_MAX ? (float)level : FLT_MAX) >> 16;
}

static void code_range(codec* c, const context* x, bool leaf, splat* s)
{
    uint32_t lowest = leaf ? 0 : s->range & 0xFFFFu, highest = STP_RANGE_INFINITE;
    uint32_t above = x->parent.range & 0xFFFFu;
    if (!leaf) {
        lowest = code_difference(c, &c->models.lowest[x->kind], 16, above, lowest);
    }
    if (x->kind != KIND_BASE) {
        highest = code_difference(c, &c->models.highest[x->kind], 16,
                                  predict_highest(c, &x->parent, s), s->range >> 16);
    }
    s->range = lowest | highest << 16;
    c->failed = c->failed || (lowest == 0) != leaf ||
                (x->kind != KIND_BASE && !stp_progressive_fits(x->parent.range, s->range));
}

/// Decodes an octahedral normal, in integers.
static void unfold(const int32_t code[2], int32_t normal[3])
{
    int32_t u = code[0], v = code[1];
    int32_t z = 127 - (int32_t)magnitude_of(u) - (int32_t)magnitude_of(v), fold = z < 0 ? -z : 0;
    normal[0] = u + (u >= 0 ? -fold : fold);
    normal[1] = v + (v >= 0 ? -fold : fold);
    normal[2] = z;
}

/// Codes two coordinates, then the one along the largest component of the parent's normal.
static void code_position(codec* c, const context* x, double share, splat* s)
{
    const int32_t* from = x->parent.position;
    int32_t normal[3];
    unfold(x->parent.normal, normal);
    int last = magnitude_of(normal[1]) > magnitude_of(normal[0]) ? 1 : 0;
    last = magnitude_of(normal[2]) > magnitude_of(normal[last]) ? 2 : last;
    assert(normal[last] != 0 && "the prediction divides by it");
    int a = (last + 1) % 3, b = (last + 2) % 3;
    const int order[3] = {a, b, last};
    for (int n = 0; n < 3; ++n) {
        int k = order[n];
        double near = (double)from[k];
        if (x->kind == KIND_SECOND) {
            near = find_opposite(from[k], x->first.position[k], share);
        } else if (x->kind == KIND_FIRST && n == 2) { // predict a point in the parent's plane
            near -= ((double)normal[a] * (double)(s->position[a] - from[a]) +
                     (double)normal[b] * (double)(s->position[b] - from[b])) /
                    (double)normal[k];
        }
        number_model* m = n == 2 ? &c->models.across[x->kind] : &c->models.along[x->kind];
        s->position[k] = (int32_t)code_difference(c, m, 16, (uint32_t)round_within(near, 0, 65535),
                                                  (uint32_t)s->position[k]);
    }
}

/// Model index: the kind, and for second children how much the first child differs from `parent`.
static uint32_t find_change(const context* x, const int32_t* parent, const int32_t* first,
                            int count)
{
    uint32_t bits = 0;
    for (int k = 0; k < count && x->kind == KIND_SECOND; ++k) {
        uint32_t own = class_of(magnitude_of(first[k] - parent[k]));
        bits = own > bits ? own : bits;
    }
    assert((uint32_t)x->kind + bits < CHANGES);
    return (uint32_t)x->kind + bits;
}

static void code_normal(codec* c, const context* x, double share, splat* s)
{
    const int32_t *parent = x->parent.normal, *first = x->first.normal;
    uint32_t at = find_change(x, parent, first, 2);
    for (int k = 0; k < 2; ++k) {
        int32_t near = x->kind != KIND_SECOND
                           ? parent[k]
                           : round_within(find_opposite(parent[k], first[k], share), -127, 127);
        uint32_t value =
            code_difference(c, &c->models.normal[at], 8, (uint32_t)near, (uint32_t)s->normal[k]);
        s->normal[k] = (int32_t)value - (value >= 128 ? 256 : 0);
    }
}

static void code_color(codec* c, const context* x, double share, splat* s)
{
    static const int order[3] = {1, 0, 2}; // green first: the others usually change like it
    const int32_t *parent = x->parent.color, *first = x->first.color;
    uint32_t at = find_change(x, parent, first, 3);
    int32_t change = 0;
    for (int n = 0; n < 3; ++n) {
        int k = order[n];
        int32_t near = x->kind != KIND_SECOND
                           ? parent[k]
                           : round_within(find_opposite(parent[k], first[k], share), 0, 255);
        number_model* m = n == 0 ? &c->models.green[at] : &c->models.other_colors[at];
        s->color[k] =
            (int32_t)code_difference(c, m, 8, (uint32_t)(near + change), (uint32_t)s->color[k]);
        change = n == 0 ? s->color[k] - near : change;
    }
}

static void code_splat(codec* c, const context* x, splat* s)
{
    models* m = &c->models;
    uint32_t sibling = x->kind != KIND_SECOND ? 0 : (x->first.range & 0xFFFFu) == 0 ? 1 : 2;
    bool leaf = code_flag(c, &m->is_leaf[sibling], (s->range & 0xFFFFu) == 0);
    code_shape(c, x, leaf, s);
    s->material = code_difference(c, &m->material[x->kind], 8, x->parent.material, s->material);
    s->coverage = code_tree(c, m->coverage[leaf ? 1 : 0], 8, s->coverage);
    double share = 0.0;
    if (x->kind == KIND_SECOND) {
        share = area_of(x->first.shape) / area_of(s->shape);
        share = share < (double)SHARE_MAX ? share : (double)SHARE_MAX;
    }
    code_position(c, x, share, s);
    code_range(c, x, leaf, s);
    code_normal(c, x, share, s);
    code_color(c, x, share, s);
}

static void begin(codec* c, const stp_splats* set)
{
    stp_bit_model* model = &c->models.is_base;
    for (size_t i = 0; i < sizeof(models) / sizeof(*model); ++i) {
        model[i] = (stp_bit_model){.zero = STP_BIT_EVEN};
    }
    c->set = set;
    c->failed = false;
    c->leaf_shape = 0;
}

/// Sets up the prediction of splat `index`.
/// @param parent UINT32_MAX: it is in the base set
static void find_context(const stp_splats* set, uint32_t base, uint32_t index, uint32_t parent,
                         context* x)
{
    x->kind = parent == UINT32_MAX ? KIND_BASE : (index - base) % 2 == 0 ? KIND_FIRST : KIND_SECOND;
    if (x->kind != KIND_BASE) {
        x->parent = load(set, parent);
        x->first = load(set, x->kind == KIND_SECOND ? index - 1 : parent);
    } else if (index > 0) {
        x->parent = load(set, index - 1);
    } else {
        x->parent = (splat){.position = {0}};
    }
}

size_t stp_operators_encode(const stp_operator_run* run, const uint32_t* parents, void* bytes,
                            size_t room)
{
    const stp_splats* set = run->set;
    assert(run->base <= run->begin && run->begin <= run->end && run->end <= set->count);
    uint32_t base = run->base, split = (run->begin - base) / 2;
    codec c;
    stp_range_encode_begin(&c.coder, bytes, room);
    begin(&c, set);
    for (uint32_t i = run->begin; i < run->end; ++i) {
        splat s = load(set, i);
        context x;
        bool in_base = base == i && s.range >> 16 == STP_RANGE_INFINITE;
        if (base == i) {
            code_flag(&c, &c.models.is_base, in_base);
            base += in_base ? 1 : 0;
            split = 0;
        }
        assert(in_base || (i - base) / 2 >= split);
        find_context(set, base, i, in_base ? UINT32_MAX : parents[(i - base) / 2 - split], &x);
        code_splat(&c, &x, &s);
    }
    return stp_range_encode_end(&c.coder);
}

/// Finds the parent of the next splat.
static void find_parent(stp_operator_reader* reader, uint32_t index, bool in_base)
{
    if (in_base) {
        reader->base += 1;
        reader->parent = UINT32_MAX;
    } else if ((index - reader->base) % 2 == 0) {
        reader->parent = stp_progressive_queue_take(&reader->queue);
    }
}

void stp_operators_skip(stp_operator_reader* reader, uint32_t begin, uint32_t end)
{
    const uint32_t* ranges = reader->queue.ranges;
    for (uint32_t i = begin; i < end; ++i) {
        find_parent(reader, i, reader->base == i && ranges[i] >> 16 >= STP_RANGE_INFINITE);
        stp_progressive_queue_add(&reader->queue, i);
    }
}

bool stp_operators_decode(const stp_operator_run* run, stp_operator_reader* reader,
                          const void* bytes, size_t size)
{
    const stp_splats* set = run->set;
    codec c;
    stp_range_decode_begin(&c.coder, bytes, size);
    assert(run->begin <= run->end && reader->base <= run->begin);
    begin(&c, set);
    for (uint32_t i = run->begin; i < run->end && !c.failed; ++i) {
        context x;
        splat s = {.position = {0}};
        bool in_base = reader->base == i && code_flag(&c, &c.models.is_base, false);
        find_parent(reader, i, in_base);
        if (!in_base && reader->parent == UINT32_MAX) {
            return false;
        }
        find_context(set, reader->base, i, reader->parent, &x);
        code_splat(&c, &x, &s);
        store(set, i, &s);
        stp_progressive_queue_add(&reader->queue, i);
    }
    return !c.failed && stp_range_decode_ends_well(&c.coder);
}

void stp_operators_begin(stp_operator_reader* reader, const uint32_t* ranges, uint32_t count,
                         uint32_t* room)
{
    stp_progressive_counts known = stp_progressive_count(ranges, count);
    assert(known.base <= count);
    reader->base = known.base;
    reader->parent = UINT32_MAX;
    reader->queue = stp_progressive_queue_begin(ranges, count, known.splits, room);
    if ((count - known.base) % 2 == 1) {
        reader->parent = stp_progressive_queue_take(&reader->queue);
    }
}
