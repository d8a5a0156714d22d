// SPDX-License-Identifier: MIT
//
// LAZ chunks of formats 6 to 10: each attribute is a layer with its own stream. Layers that are not
// kept (flags, user data, wave packets, extra bytes) are skipped. Blocks are decoded layer by
// layer: the first layer determines which values change, and which models the others use.
//
// Each of the four scanner channels has its own models and last values. They start when the channel
// first appears, with the values of the previous point.
//
// The layers follow LASzip's items POINT14 (without flags and user data), RGB14 and RGBNIR14, of
// versions 3 and 4. docs/formats.md says what was compared with LASzip.
#include "base/io/bytes.h"
#include "import/las/laz.h"
#include "import/las/laz_items.h"

#include <assert.h>

enum {
    CHANNELS = 4,
    RETURN_CONTEXTS = 6,
    LEVELS = 8,
    SYMBOL_BYTES = 64, // upper bound for one value, except x and y together
    POINT_BYTES = 128,
    // bits of the first layer
    CHANNEL_MASK = 3,
    NEW_TIME = 4,
    NEW_ANGLE = 8,
    NEW_SOURCE = 16,
    FIRST_RETURN = 32,
    LAST_RETURN = 64
};

typedef enum layer_kind {
    XY,
    Z,
    CLASS,
    FLAGS,
    INTENSITY,
    ANGLE,
    USER,
    SOURCE,
    TIME,
    RGB,
    NIR
} layer_kind;
enum { LAYERS = NIR + 1, POINT_LAYERS = TIME + 1 };

typedef struct layer {
    stp_laz_decoder decoder;
    bool changes;     ///< otherwise all points have the first one's value
    unsigned channel; ///< channel of the last point
    unsigned met;     ///< bit c: channel c has last values
    unsigned char tail[STP_LAZ_TAIL];
} layer;

typedef struct channel_models {
    stp_laz_model changed[8], channel, counts[16], numbers[16], same_pulse;
    stp_laz_integer x, y, z, intensity, angle, source;
    stp_laz_model classes[64];
    stp_laz_time time;
    stp_laz_rgb rgb;
    stp_laz_model nir_used, nir_bytes[2];

    // last values
    int32_t position[2];
    uint8_t return_number, return_count, class;
    bool new_time;
    stp_laz_median x_steps[2 * RETURN_CONTEXTS], y_steps[2 * RETURN_CONTEXTS];
    int32_t height, heights[LEVELS];
    uint16_t last_intensity, intensities[LEVELS], last_source, color[3], last_nir;
    int16_t last_angle;
} channel_models;

struct stp_laz_layered {
    channel_models channels[CHANNELS];
    layer layers[LAYERS];
    bool fixed;                  ///< colours follow their own channel; see next_rgb
    uint8_t said[STP_LAS_BLOCK]; ///< per point: channel and bits of the first layer
    uint8_t z_context[STP_LAS_BLOCK];
};

// Contexts by number of returns and return number.
static const uint8_t return_contexts[16][16] = {
    {0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5},
    {1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3},
    {2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3},
    {3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
    {4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
    {5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
    {3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4},
    {4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4},
    {4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4},
    {5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4},
    {5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4},
    {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4},
    {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4},
    {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4},
    {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5},
    {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5},
};

stp_laz_layered* stp_laz_layered_create(const stp_las* las)
{
    return STP_NEW_ZEROED(las->context, stp_laz_layered, 1);
}

void stp_laz_layered_make(stp_laz_pool* pool, stp_laz_layered* l)
{
    for (int i = 0; i < CHANNELS; ++i) {
        channel_models* c = &l->channels[i];
        stp_laz_models_make(pool, c->changed, 8, 128);
        stp_laz_model_make(pool, &c->channel, 3);
        stp_laz_models_make(pool, c->counts, 16, 16);
        stp_laz_models_make(pool, c->numbers, 16, 16);
        stp_laz_model_make(pool, &c->same_pulse, 13);
        stp_laz_integer_make(pool, &c->x, 32, 2);
        stp_laz_integer_make(pool, &c->y, 32, 22);
        stp_laz_integer_make(pool, &c->z, 32, 20);
        stp_laz_integer_make(pool, &c->intensity, 16, 4);
        stp_laz_integer_make(pool, &c->angle, 16, 2);
        stp_laz_integer_make(pool, &c->source, 16, 1);
        stp_laz_models_make(pool, c->classes, 64, 256);
        stp_laz_time_make(pool, &c->time, 0);
        stp_laz_rgb_make(pool, &c->rgb);
        stp_laz_model_make(pool, &c->nir_used, 4);
        stp_laz_models_make(pool, c->nir_bytes, 2, 256);
    }
}

// Opens the layers: their sizes come first, then all data.
static bool open_layers(stp_laz* laz, const unsigned char* bytes, size_t size)
{
    const stp_las* las = laz->las;
    stp_laz_layered* l = laz->layered;
    bool has_rgb = las->layout.rgb != STP_LAS_NO_FIELD,
         has_nir = las->layout.nir != STP_LAS_NO_FIELD;
    bool has_wave = las->layout.wave != STP_LAS_NO_FIELD;
    size_t known = (size_t)POINT_LAYERS + has_rgb + has_nir;
    size_t all = known + has_wave + las->record_size - las->layout.size;
    if (size < 4 + 4 * all || stp_read_u32(bytes) != laz->chunk.count) {
        return false;
    }
    assert(known <= LAYERS && all >= known && (has_rgb || !has_nir));
    const unsigned char* sizes = bytes + 4;
    uint64_t at = 4 + 4 * (uint64_t)all;
    for (size_t i = 0; i < LAYERS; ++i) {
        bool there = i < known; // colours come before near infrared, which comes with them only
        uint64_t length = there ? stp_read_u32(sizes + 4 * i) : 0;
        layer* at_layer = &l->layers[i];
        if (at > size || length > size - at) {
            return false;
        }
        at_layer->changes = length > 0;
        if (length > 0) {
            at_layer->decoder =
                stp_laz_decoder_begin(bytes + at, (size_t)length, at_layer->tail, laz->epoch);
        }
        at += length;
    }
    return l->layers[XY].changes || laz->chunk.count == 1;
}

bool stp_laz_layered_begin(stp_laz* laz, const stp_las_block* block, const unsigned char* raw,
                           const unsigned char* bytes, size_t size)
{
    stp_laz_layered* l = laz->layered;
    unsigned channel = raw[15] >> 4 & (CHANNELS - 1);
    channel_models* c = &l->channels[channel];
    if (!open_layers(laz, bytes, size)) {
        return false;
    }
    for (int i = 0; i < LAYERS; ++i) {
        l->layers[i].channel = channel;
        l->layers[i].met = 1u << channel;
    }
    l->fixed = laz->las->items_fixed;
    c->return_number = block->return_number[0];
    c->return_count = block->return_count[0];
    c->new_time = false;
    c->position[0] = block->position[0][0];
    c->position[1] = block->position[1][0];
    memset(c->x_steps, 0, sizeof(c->x_steps));
    memset(c->y_steps, 0, sizeof(c->y_steps));
    c->height = block->position[2][0];
    c->class = block->classes[0];
    c->last_intensity = block->intensity[0];
    c->last_angle = block->angle[0];
    c->last_source = block->source[0];
    c->last_nir = block->nir[0];
    for (int k = 0; k < 3; ++k) {
        c->color[k] = block->rgb[k][0];
    }
    for (int k = 0; k < LEVELS; ++k) {
        c->heights[k] = c->height;
        c->intensities[k] = c->last_intensity;
    }
    stp_laz_time_begin(&c->time, block->time[0]);
    return true;
}

// Switches to the channel of a point. @return whether it is new to the layer
static inline bool enter(layer* at, unsigned channel)
{
    assert(channel < CHANNELS && (at->met >> at->channel & 1) != 0);
    bool first = (at->met >> channel & 1) == 0;
    at->met |= 1u << channel;
    at->channel = channel;
    return first;
}

// The channel of the point. A new channel takes over the last point's values.
static channel_models* next_channel(stp_laz_decoder* d, stp_laz_layered* l, unsigned changed)
{
    layer* at = &l->layers[XY];
    channel_models* before = &l->channels[at->channel];
    if ((changed >> 6 & 1) == 0) {
        return before;
    }
    unsigned channel = (at->channel + stp_laz_symbol(d, &before->channel) + 1) % CHANNELS;
    channel_models* c = &l->channels[channel];
    if (enter(at, channel)) {
        c->return_number = before->return_number;
        c->return_count = before->return_count;
        c->new_time = false;
        memcpy(c->position, before->position, sizeof(c->position));
        memset(c->x_steps, 0, sizeof(c->x_steps));
        memset(c->y_steps, 0, sizeof(c->y_steps));
    }
    return c;
}

static inline void next_returns(stp_laz_decoder* d, channel_models* c, unsigned changed)
{
    if (changed & 4) {
        c->return_count = (uint8_t)stp_laz_symbol(d, &c->counts[c->return_count]);
    }
    unsigned last = c->return_number;
    switch (changed & 3) {
    case 1:
        c->return_number = (last + 1) & 15;
        break;
    case 2:
        c->return_number = (last + 15) & 15;
        break;
    case 3:
        c->return_number = changed & 16
                               ? (uint8_t)stp_laz_symbol(d, &c->numbers[last])
                               : (uint8_t)((last + stp_laz_symbol(d, &c->same_pulse) + 2) & 15);
        break;
    default:
        break;
    }
}

static void next_xy(stp_laz_layered* l, size_t first, size_t count, stp_las_block* block)
{
    layer* at = &l->layers[XY];
    stp_laz_decoder d = at->decoder;
    for (size_t i = first; i < first + count; ++i) {
        stp_laz_ensure(&d, POINT_BYTES);
        channel_models* c = &l->channels[at->channel];
        unsigned context = (c->return_number == 1 ? 1u : 0u) |
                           (c->return_number >= c->return_count ? 2u : 0u) |
                           (c->new_time ? 4u : 0u);
        unsigned changed = stp_laz_symbol(&d, &c->changed[context]);
        c = next_channel(&d, l, changed);
        next_returns(&d, c, changed);
        unsigned n = c->return_count, r = c->return_number, single = n == 1;
        assert(n < 16 && r < 16 && at->channel < CHANNELS);
        c->new_time = changed >> 4 & 1;
        unsigned steps = return_contexts[n][r] * 2u + c->new_time;
        stp_laz_median *x_steps = &c->x_steps[steps], *y_steps = &c->y_steps[steps];
        uint32_t step = (uint32_t)x_steps->values[2] + stp_laz_difference(&d, &c->x, single);
        c->position[0] = (int32_t)((uint32_t)c->position[0] + step);
        stp_laz_median_add(x_steps, (int32_t)step);
        step = (uint32_t)y_steps->values[2] +
               stp_laz_difference(&d, &c->y, single + stp_laz_size_context(c->x.k, 20));
        c->position[1] = (int32_t)((uint32_t)c->position[1] + step);
        stp_laz_median_add(y_steps, (int32_t)step);
        block->position[0][i] = c->position[0];
        block->position[1][i] = c->position[1];
        block->return_number[i] = c->return_number;
        block->return_count[i] = c->return_count;
        l->z_context[i] = (uint8_t)(single + stp_laz_size_context((c->x.k + c->y.k) / 2, 18));
        l->said[i] =
            (uint8_t)(at->channel | (changed >> 4 & 1 ? NEW_TIME : 0) |
                      (changed >> 3 & 1 ? NEW_ANGLE : 0) | (changed >> 5 & 1 ? NEW_SOURCE : 0) |
                      (r == 1 ? FIRST_RETURN : 0) | (r >= n ? LAST_RETURN : 0));
    }
    at->decoder = d;
}

static void next_z(stp_laz_layered* l, size_t first, size_t count, stp_las_block* block)
{
    layer* at = &l->layers[Z];
    stp_laz_decoder d = at->decoder;
    for (size_t i = first; i < first + count; ++i) {
        unsigned channel = l->said[i] & CHANNEL_MASK;
        channel_models* c = &l->channels[channel];
        if (channel != at->channel) {
            int32_t last = l->channels[at->channel].height;
            if (enter(at, channel)) {
                for (int k = 0; k < LEVELS; ++k) {
                    c->heights[k] = last;
                }
            }
        }
        stp_laz_ensure(&d, SYMBOL_BYTES);
        unsigned n = block->return_count[i], r = block->return_number[i];
        unsigned level = n > r ? n - r : r - n;
        level = level < LEVELS ? level : LEVELS - 1;
        assert(l->z_context[i] < 20 && "the models of z");
        uint32_t step = stp_laz_difference(&d, &c->z, l->z_context[i]);
        c->height = (int32_t)((uint32_t)c->heights[level] + step);
        c->heights[level] = c->height;
        block->position[2][i] = c->height;
    }
    at->decoder = d;
}

static void next_class(stp_laz_layered* l, size_t first, size_t count, stp_las_block* block)
{
    layer* at = &l->layers[CLASS];
    stp_laz_decoder d = at->decoder;
    for (size_t i = first; i < first + count; ++i) {
        unsigned channel = l->said[i] & CHANNEL_MASK;
        channel_models* c = &l->channels[channel];
        if (channel != at->channel) {
            uint8_t last = l->channels[at->channel].class;
            c->class = enter(at, channel) ? last : c->class;
        }
        stp_laz_ensure(&d, SYMBOL_BYTES);
        unsigned single =
            (l->said[i] & (FIRST_RETURN | LAST_RETURN)) == (FIRST_RETURN | LAST_RETURN);
        unsigned context = (c->class & 31u) << 1 | single;
        c->class = (uint8_t)stp_laz_symbol(&d, &c->classes[context]);
        block->classes[i] = c->class;
    }
    at->decoder = d;
}

static void next_intensity(stp_laz_layered* l, size_t first, size_t count, stp_las_block* block)
{
    layer* at = &l->layers[INTENSITY];
    stp_laz_decoder d = at->decoder;
    for (size_t i = first; i < first + count; ++i) {
        unsigned said = l->said[i], channel = said & CHANNEL_MASK;
        channel_models* c = &l->channels[channel];
        if (channel != at->channel) {
            uint16_t last = l->channels[at->channel].last_intensity;
            if (enter(at, channel)) {
                for (int k = 0; k < LEVELS; ++k) {
                    c->intensities[k] = last;
                }
            }
        }
        stp_laz_ensure(&d, SYMBOL_BYTES);
        unsigned kind = (said & FIRST_RETURN ? 1u : 0) | (said & LAST_RETURN ? 2u : 0);
        uint16_t* last = &c->intensities[kind << 1 | (said & NEW_TIME ? 1u : 0)];
        *last = (uint16_t)(*last + stp_laz_difference(&d, &c->intensity, kind));
        block->intensity[i] = c->last_intensity = *last;
    }
    at->decoder = d;
}

static void next_angle(stp_laz_layered* l, size_t first, size_t count, stp_las_block* block)
{
    layer* at = &l->layers[ANGLE];
    stp_laz_decoder d = at->decoder;
    for (size_t i = first; i < first + count; ++i) {
        unsigned said = l->said[i], channel = said & CHANNEL_MASK;
        channel_models* c = &l->channels[channel];
        if (channel != at->channel) {
            int16_t last = l->channels[at->channel].last_angle;
            c->last_angle = enter(at, channel) ? last : c->last_angle;
        }
        if (said & NEW_ANGLE) {
            stp_laz_ensure(&d, SYMBOL_BYTES);
            uint32_t step = stp_laz_difference(&d, &c->angle, said & NEW_TIME ? 1 : 0);
            c->last_angle = (int16_t)(uint16_t)((uint32_t)c->last_angle + step);
        }
        block->angle[i] = c->last_angle;
    }
    at->decoder = d;
}

static void next_source(stp_laz_layered* l, size_t first, size_t count, stp_las_block* block)
{
    layer* at = &l->layers[SOURCE];
    stp_laz_decoder d = at->decoder;
    for (size_t i = first; i < first + count; ++i) {
        unsigned said = l->said[i], channel = said & CHANNEL_MASK;
        channel_models* c = &l->channels[channel];
        if (channel != at->channel) {
            uint16_t last = l->channels[at->channel].last_source;
            c->last_source = enter(at, channel) ? last : c->last_source;
        }
        if (said & NEW_SOURCE) {
            stp_laz_ensure(&d, SYMBOL_BYTES);
            c->last_source = (uint16_t)(c->last_source + stp_laz_difference(&d, &c->source, 0));
        }
        block->source[i] = c->last_source;
    }
    at->decoder = d;
}

static void next_time(stp_laz_layered* l, size_t first, size_t count, stp_las_block* block)
{
    layer* at = &l->layers[TIME];
    stp_laz_decoder d = at->decoder;
    for (size_t i = first; i < first + count; ++i) {
        unsigned said = l->said[i], channel = said & CHANNEL_MASK;
        stp_laz_time* time = &l->channels[channel].time;
        if (channel != at->channel) {
            const stp_laz_time* before = &l->channels[at->channel].time;
            uint64_t last = before->times[before->last];
            if (enter(at, channel)) {
                stp_laz_time_begin(time, last);
            }
        }
        if (said & NEW_TIME) {
            stp_laz_ensure(&d, POINT_BYTES);
            (void)stp_laz_time_next(&d, time, 0);
        }
        block->time[i] = time->times[time->last];
    }
    at->decoder = d;
}

// Location of a point's last colour. Writers of version 3 continue from the last point's colour if
// its channel is a different, already known one, and store the new colour there.
static channel_models* enter_color(stp_laz_layered* l, layer* at, unsigned channel, bool* first)
{
    channel_models *before = &l->channels[at->channel], *now = &l->channels[channel];
    bool stays = channel == at->channel;
    *first = !stays && enter(at, channel);
    return stays || *first || l->fixed ? now : before;
}

static void next_rgb(stp_laz_layered* l, size_t first, size_t count, stp_las_block* block)
{
    layer* at = &l->layers[RGB];
    stp_laz_decoder d = at->decoder;
    for (size_t i = first; i < first + count; ++i) {
        unsigned channel = l->said[i] & CHANNEL_MASK;
        const channel_models* before = &l->channels[at->channel];
        bool is_first;
        channel_models* last = enter_color(l, at, channel, &is_first);
        if (is_first) {
            memcpy(last->color, before->color, sizeof(last->color));
        }
        uint16_t next[3];
        stp_laz_ensure(&d, SYMBOL_BYTES);
        stp_laz_rgb_next(&d, &l->channels[channel].rgb, last->color, next);
        for (int k = 0; k < 3; ++k) {
            block->rgb[k][i] = last->color[k] = next[k];
        }
    }
    at->decoder = d;
}

static void next_nir(stp_laz_layered* l, size_t first, size_t count, stp_las_block* block)
{
    layer* at = &l->layers[NIR];
    stp_laz_decoder d = at->decoder;
    for (size_t i = first; i < first + count; ++i) {
        unsigned channel = l->said[i] & CHANNEL_MASK;
        const channel_models* before = &l->channels[at->channel];
        bool is_first;
        channel_models *last = enter_color(l, at, channel, &is_first), *c = &l->channels[channel];
        last->last_nir = is_first ? before->last_nir : last->last_nir;
        int low = last->last_nir & 255, high = last->last_nir >> 8;
        stp_laz_ensure(&d, SYMBOL_BYTES);
        unsigned used = stp_laz_symbol(&d, &c->nir_used);
        low = used & 1 ? stp_laz_byte(&d, &c->nir_bytes[0], low) : low;
        high = used & 2 ? stp_laz_byte(&d, &c->nir_bytes[1], high) : high;
        block->nir[i] = last->last_nir = (uint16_t)(low | high << 8);
    }
    at->decoder = d;
}

// An empty layer: every point has the value of the first, which that point's channel still holds.
static void repeat(const stp_laz_layered* l, layer_kind kind, size_t first, size_t count,
                   stp_las_block* block)
{
    const channel_models* c = &l->channels[l->layers[kind].channel];
    for (size_t i = first; i < first + count; ++i) {
        switch (kind) {
        case Z:
            block->position[2][i] = c->height;
            break;
        case CLASS:
            block->classes[i] = c->class;
            break;
        case INTENSITY:
            block->intensity[i] = c->last_intensity;
            break;
        case ANGLE:
            block->angle[i] = c->last_angle;
            break;
        case SOURCE:
            block->source[i] = c->last_source;
            break;
        case TIME:
            block->time[i] = c->time.times[c->time.last];
            break;
        case RGB:
            block->rgb[0][i] = c->color[0];
            block->rgb[1][i] = c->color[1];
            block->rgb[2][i] = c->color[2];
            break;
        case NIR:
            block->nir[i] = c->last_nir;
            break;
        default:
            break;
        }
    }
}

bool stp_laz_layered_next(stp_laz* laz, size_t first, size_t count, stp_las_block* block)
{
    typedef void layer_reader(stp_laz_layered*, size_t, size_t, stp_las_block*);
    static layer_reader* const readers[LAYERS] = {
        [XY] = next_xy,       [Z] = next_z,
        [CLASS] = next_class, [INTENSITY] = next_intensity,
        [ANGLE] = next_angle, [SOURCE] = next_source,
        [TIME] = next_time,   [RGB] = next_rgb,
        [NIR] = next_nir};
    assert(first + count <= STP_LAS_BLOCK);
    stp_laz_layered* l = laz->layered;
    bool good = true;
    for (int i = 0; i < LAYERS && count > 0; ++i) {
        if (readers[i] == NULL) {
            continue; // not kept
        }
        if (l->layers[i].changes) {
            readers[i](l, first, count, block);
            good = good && stp_laz_is_good(&l->layers[i].decoder);
        } else {
            repeat(l, (layer_kind)i, first, count, block);
        }
    }
    return good;
}
