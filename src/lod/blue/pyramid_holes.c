// SPDX-License-Identifier: MIT
//
// Closes visible holes. Each partly covered disk is correct alone, but several layers of them can
// show the background inside a solid model. The disks of an octave are drawn from the capture's
// directions and compared with its silhouettes. A disk inside all silhouettes whose pixels stay
// open is drawn whole. A disk with solid surface behind it, such as a tree in front of the ground,
// keeps its coverage.
#include "base/splats/octahedral.h"
#include "lod/blue/pyramid.h"

#include <assert.h>

#define RADIUS 3.0 // minimum radius of a disk in a picture, in pixels, if silhouettes have as many
#define MIN_FACING 0.2 // cosine: disks are not seen from flatter directions
// Share of a disk's pixels outside a silhouette: closed up to the first value, not from the second.
#define OUTER_FEW 0.0f
#define OUTER_MAX 0.1f
// Mean probability that a disk's pixels stay open: kept up to the first value, closed from the
// second.
#define OPEN_FEW 0.0f
#define MAX_OPEN 0.01f
#define GRAIN 4096

// A disk's centre, normal and axes, in scene units.
typedef struct placed_disk {
    stp_vec3 at, normal, x, y;
} placed_disk;

// A disk's measurements in a view.
typedef struct verdict {
    float outer; ///< share of its pixels outside the silhouette
    float open;  ///< mean probability that nothing is drawn at pixels where something was seen
} verdict;

typedef struct closer {
    stp_pyramid* p;
    const stp_pyramid_entry* entries;
    uint32_t count; ///< disks
    float radius;
    placed_disk* disks;
    stp_disk_clip clips[256];           ///< by code
    uint32_t shrink;                    ///< silhouette pixels per picture pixel, along each side
    verdict* verdicts[STP_SILHOUETTES]; ///< per view, one per disk
    bool failed[STP_SILHOUETTES];
} closer;

// One view of an octave.
typedef struct picture {
    const stp_silhouette* from;
    double scale; ///< picture pixels per silhouette pixel
    uint32_t width, height;
    float* seen; ///< per pixel, the share where the capture saw anything
    float* open; ///< per pixel, the probability that no disk is drawn
} picture;

// A disk in a picture: u and v, relative to the radius, are linear in pixels.
typedef struct outline {
    double x, y; ///< centre
    double u[2], v[2];
    uint32_t left, right, top, bottom; ///< pixels, within the picture
} outline;

static uint32_t clamp_to(double value, uint32_t maximum)
{
    return value > 0.0 ? value < (double)maximum ? (uint32_t)value : maximum : 0;
}

static bool make_outline(const closer* c, const picture* view, uint32_t surfel, outline* out)
{
    const placed_disk* disk = &c->disks[surfel];
    const stp_silhouette* s = view->from;
    stp_vec3d place = stp_to_double(disk->at), x = stp_to_double(disk->x);
    stp_vec3d y = stp_to_double(disk->y);
    if (stp_dotd(s->toward, stp_to_double(disk->normal)) < MIN_FACING) {
        return false;
    }
    double reach = (double)c->radius * view->scale;
    double ax = stp_dotd(s->right, x) * reach, ay = stp_dotd(s->down, x) * reach;
    double bx = stp_dotd(s->right, y) * reach, by = stp_dotd(s->down, y) * reach;
    double area = ax * by - ay * bx;
    if (!(fabs(area) > 1e-12)) {
        return false;
    }
    *out = (outline){.x = (stp_dotd(s->right, place) + s->shift_x) * view->scale,
                     .y = (stp_dotd(s->down, place) + s->shift_y) * view->scale,
                     .u = {by / area, -bx / area},
                     .v = {-ay / area, ax / area}};
    double wide = sqrt(ax * ax + bx * bx), high = sqrt(ay * ay + by * by);
    out->left = clamp_to(out->x - wide, view->width);
    out->right = clamp_to(out->x + wide + 1.0, view->width);
    out->top = clamp_to(out->y - high, view->height);
    out->bottom = clamp_to(out->y + high + 1.0, view->height);
    assert(out->left <= out->right && out->top <= out->bottom);
    return true;
}

// Pixels of a row with centres covered by the drawn part of a disk.
static void find_span(const outline* o, const stp_disk_clip* clip, uint32_t row, uint32_t span[2])
{
    // (u0 + du x)^2 + (v0 + dv x)^2 <= 1, x from the left column's centre on
    double dy = (double)row + 0.5 - o->y, dx = (double)o->left + 0.5 - o->x;
    double u0 = o->u[0] * dx + o->u[1] * dy, v0 = o->v[0] * dx + o->v[1] * dy;
    double du = o->u[0], dv = o->v[0];
    double a = du * du + dv * dv, b = u0 * du + v0 * dv, c = u0 * u0 + v0 * v0 - 1.0;
    double root = b * b - a * c;
    span[0] = span[1] = o->left;
    if (!(root >= 0.0 && a > 0.0)) {
        return;
    }
    root = sqrt(root);
    double begin = (-b - root) / a, end = (-b + root) / a;
    if (clip != NULL) { // low <= t0 + dt x <= high
        double t0 = (double)clip->across * u0 + (double)clip->along * v0;
        double dt = (double)clip->across * du + (double)clip->along * dv;
        double low = (double)clip->low - t0, high = (double)clip->high - t0;
        if (fabs(dt) > 1e-9) {
            double first = (dt > 0.0 ? low : high) / dt, last = (dt > 0.0 ? high : low) / dt;
            begin = first > begin ? first : begin;
            end = last < end ? last : end;
        } else if (low > 0.0 || high < 0.0) {
            return;
        }
    }
    if (end >= begin && end >= 0.0) {
        span[0] = o->left + clamp_to(ceil(begin), o->right - o->left);
        span[1] = o->left + clamp_to(floor(end) + 1.0, o->right - o->left);
        assert(span[0] <= span[1] && span[1] <= o->right);
    }
}

// How many of `count` pixels of a row are set, from `x` on.
static uint32_t count_pixels(const uint32_t* words, uint32_t width, uint32_t x, uint32_t count)
{
    uint32_t sum = 0, end = x + count < width ? x + count : width;
    while (x < end) {
        uint32_t bits = words[x / 32] >> (x % 32), here = 32 - x % 32;
        here = here < end - x ? here : end - x;
        bits &= here < 32 ? (1u << here) - 1 : UINT32_MAX;
        sum += (uint32_t)__builtin_popcount(bits);
        x += here;
    }
    assert(sum <= count);
    return sum;
}

// Shrinks a silhouette.
static bool begin_picture(const closer* c, const stp_silhouette* from, picture* made)
{
    uint32_t shrink = c->shrink, stride = stp_silhouette_stride(from->width);
    *made = (picture){.from = from,
                      .scale = 1.0 / (double)shrink,
                      .width = (from->width + shrink - 1) / shrink,
                      .height = (from->height + shrink - 1) / shrink};
    size_t size = (size_t)made->width * made->height;
    made->seen = STP_NEW_ARRAY(c->p->context, float, 2 * size);
    made->open = made->seen != NULL ? made->seen + size : NULL;
    float each = 1.0f / ((float)shrink * (float)shrink);
    for (uint32_t y = 0; made->seen != NULL && y < made->height; ++y) {
        float* seen = made->seen + (size_t)y * made->width;
        uint32_t first = y * shrink, last = first + shrink;
        last = last < from->height ? last : from->height;
        for (uint32_t x = 0; x < made->width; ++x) {
            uint32_t count = 0;
            for (uint32_t row = first; row < last; ++row) {
                count += count_pixels(from->words + (size_t)row * stride, from->width, x * shrink,
                                      shrink);
            }
            seen[x] = (float)count * each;
            seen[size + x] = 1.0f;
        }
    }
    return made->seen != NULL;
}

static void draw_disk(const closer* c, const picture* view, const outline* o, uint8_t code)
{
    assert(o->right <= view->width && o->bottom <= view->height);
    const stp_disk_clip* clip = stp_coverage_clips(code) ? &c->clips[code] : NULL;
    float left = 1.0f - (float)stp_coverage_share(code) / 255.0f;
    for (uint32_t row = o->top; row < o->bottom; ++row) {
        uint32_t span[2];
        find_span(o, clip, row, span);
        float* open = view->open + (size_t)row * view->width;
        for (uint32_t x = span[0]; x < span[1]; ++x) {
            open[x] *= left;
        }
    }
}

static verdict classify_disk(const picture* view, const outline* o)
{
    uint32_t count = 0;
    float seen = 0.0f, open = 0.0f;
    for (uint32_t row = o->top; row < o->bottom; ++row) {
        uint32_t span[2];
        find_span(o, NULL, row, span);
        size_t first = (size_t)row * view->width;
        for (uint32_t x = span[0]; x < span[1]; ++x) {
            seen += view->seen[first + x];
            open += view->seen[first + x] * view->open[first + x];
        }
        count += span[1] - span[0];
    }
    float each = count != 0 ? 1.0f / (float)count : 0.0f;
    return (verdict){.outer = count != 0 ? 1.0f - seen * each : 0.0f, .open = open * each};
}

static void close_in_view(const closer* c, uint32_t index, const picture* view)
{
    outline o;
    for (uint32_t i = 0; i < c->count; ++i) {
        if (make_outline(c, view, i, &o)) {
            draw_disk(c, view, &o, c->entries[i].coverage);
        }
    }
    for (uint32_t i = 0; i < c->count; ++i) {
        c->verdicts[index][i] = (verdict){0};
        if (c->entries[i].coverage != STP_COVERAGE_WHOLE && make_outline(c, view, i, &o)) {
            c->verdicts[index][i] = classify_disk(view, &o);
        }
    }
}

static void place_disks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const closer* c = user;
    for (size_t i = begin; i < end; ++i) {
        const float* n = c->p->input->normals + 3 * i;
        const float* at = c->p->input->positions + 3 * i;
        int8_t code[2];
        stp_octahedral_encode((stp_vec3){n[0], n[1], n[2]}, code);
        stp_disk_axes axes = stp_disk_axes_of((float)code[0], (float)code[1]);
        c->disks[i] = (placed_disk){{at[0], at[1], at[2]}, {n[0], n[1], n[2]}, axes.x, axes.y};
    }
}

static void close_in_views(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    closer* c = user;
    stp_context* context = c->p->context;
    for (size_t i = begin; i < end; ++i) {
        picture view;
        c->verdicts[i] = STP_NEW_ARRAY(context, verdict, c->count);
        bool made = begin_picture(c, &c->p->input->finish->candidates->silhouettes[i], &view);
        c->failed[i] = !made || c->verdicts[i] == NULL;
        if (!c->failed[i]) {
            close_in_view(c, (uint32_t)i, &view);
        }
        stp_free(context, view.seen);
    }
}

static float ramp(float value, float low, float high)
{
    assert(low < high);
    return stp_clamp((value - low) / (high - low), 0.0f, 1.0f);
}

// Degree to which a disk is closed, 0 to 1: the most open view requests it, the most exposed view
// limits it.
static float closing(const closer* c, uint32_t views, uint32_t surfel)
{
    float outer = 0.0f, open = 0.0f;
    for (uint32_t v = 0; v < views; ++v) {
        outer = stp_max(outer, c->verdicts[v][surfel].outer);
        open = stp_max(open, c->verdicts[v][surfel].open);
    }
    return ramp(open, OPEN_FEW, MAX_OPEN) * (1.0f - ramp(outer, OUTER_FEW, OUTER_MAX));
}

static void close_disks(const closer* c, uint32_t views, stp_pyramid_entry* entries)
{
    for (uint32_t i = 0; i < c->count; ++i) {
        uint8_t code = entries[i].coverage;
        float part = code != STP_COVERAGE_WHOLE ? closing(c, views, i) : 0.0f;
        if (part >= 1.0f || (part >= 0.5f && stp_coverage_clips(code))) {
            entries[i].coverage = STP_COVERAGE_WHOLE;
        } else if (part > 0.0f && !stp_coverage_clips(code)) {
            double share = (double)stp_coverage_share(code) / 255.0;
            entries[i].coverage = stp_coverage_of_share(share + (1.0 - share) * (double)part);
        }
    }
}

stp_result stp_pyramid_close_holes(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan)
{
    const stp_candidates* from = p->input->finish->candidates;
    uint32_t views = from->silhouette_count, doubtful = 0;
    closer c = {.p = p,
                .entries = p->octaves[octave],
                .count = p->surfels->octave_ends[octave],
                .radius = plan->disk_radius};
    for (uint32_t i = 0; i < c.count; ++i) {
        doubtful += c.entries[i].coverage != STP_COVERAGE_WHOLE;
    }
    assert(views <= STP_SILHOUETTES);
    if (views == 0 || doubtful == 0) {
        return STP_OK;
    }
    for (int code = STP_COVERAGE_HALVES; code < STP_COVERAGE_WHOLE; ++code) {
        c.clips[code] = stp_coverage_clip((uint8_t)code);
    }
    double pixels = (double)plan->disk_radius / from->pixel_size / RADIUS;
    c.shrink = pixels >= 2.0 ? pixels < 4096.0 ? (uint32_t)pixels : 4096 : 1;
    assert(c.shrink > 0);
    c.disks = STP_NEW_ARRAY(p->context, placed_disk, c.count);
    if (c.disks == NULL) {
        return stp_fail_memory(p->context);
    }
    stp_parallel_for(p->context, c.count, GRAIN, place_disks, &c);
    stp_parallel_for(p->context, views, 1, close_in_views, &c);
    bool failed = false;
    for (uint32_t v = 0; v < views; ++v) {
        failed = failed || c.failed[v];
    }
    if (!failed) {
        close_disks(&c, views, p->octaves[octave]);
    }
    for (uint32_t v = 0; v < views; ++v) {
        stp_free(p->context, c.verdicts[v]);
    }
    stp_free(p->context, c.disks);
    return failed ? stp_fail_memory(p->context) : STP_OK;
}
