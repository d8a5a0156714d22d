// SPDX-License-Identifier: MIT
// Which splats of sets a capture saw, and their candidates.
#include "base/math/color.h"
#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "base/splats/splat_columns.h"
#include "capture/splat_disks.h"

#include <assert.h>

#define MIN_FACING 0.3      // cosine: views at flatter angles do not decide a centre's visibility
#define DEPTH_TOLERANCE 0.5 // maximum depth of a centre behind the visible surface, in radii
#define WORDS_PER_TASK 512u // words of bits resolved by one task of a loop

stp_vec3d stp_set_position(const stp_set_placing* placing, uint32_t splat)
{
    return stp_affine_point(&placing->placement, stp_splat_place(placing->splats, splat));
}

/// Turns a unit normal of a set.
static stp_vec3d place_normal(const stp_set_placing* placing, stp_vec3d n)
{
    const double(*m)[3] = placing->normal_matrix;
    stp_vec3d turned = {m[0][0] * n.x + m[0][1] * n.y + m[0][2] * n.z,
                        m[1][0] * n.x + m[1][1] * n.y + m[1][2] * n.z,
                        m[2][0] * n.x + m[2][1] * n.y + m[2][2] * n.z};
    turned = stp_normalized(turned);
    return stp_dotd(turned, turned) > 0.5 ? turned : n; // a degenerate transform
}

stp_vec3d stp_set_normal(const stp_set_placing* placing, uint32_t splat)
{
    const int8_t* code = placing->splats->normals + 2 * (size_t)splat;
    return place_normal(placing, stp_to_double(stp_octahedral_decode(code[0], code[1])));
}

stp_result stp_capture_prepare_sets(stp_capture_job* job, stp_boxd* box)
{
    stp_context* context = job->scene->context;
    job->first_splats = STP_NEW_ARRAY(context, uint64_t, job->set_count + 1);
    job->set_boxes = STP_NEW_ARRAY(context, stp_boxd, job->set_count + 1);
    if (job->first_splats == NULL || job->set_boxes == NULL) {
        return stp_fail_memory(context);
    }
    uint64_t sum = 0;
    for (size_t i = 0; i < job->set_count; ++i) {
        const stp_placed_set* set = &job->sets[i];
        assert(set->prefix <= set->splats->count && !(set->radius < 0.0f));
        stp_set_placing placing = stp_set_placing_make(set->splats, &set->transform);
        stp_boxd points = stp_boxd_empty();
        for (uint32_t k = 0; k < set->prefix; ++k) {
            stp_boxd_add(&points, stp_set_position(&placing, k));
        }
        double reach = (double)set->radius * stp_affine_stretch(&set->transform);
        stp_vec3d margin = {reach, reach, reach};
        job->set_boxes[i] = (stp_boxd){stp_subd(points.min, margin), stp_addd(points.max, margin)};
        stp_boxd_add(box, job->set_boxes[i].min);
        stp_boxd_add(box, job->set_boxes[i].max);
        job->first_splats[i] = sum;
        sum += set->prefix;
    }
    job->first_splats[job->set_count] = sum;
    size_t words = (size_t)(sum / 32 + 1);
    job->seen = STP_NEW_ZEROED(context, _Atomic uint32_t, words);
    return job->seen != NULL ? STP_OK : stp_fail_memory(context);
}

void stp_capture_drop_sets(stp_capture_job* job)
{
    stp_context* context = job->scene->context;
    stp_free(context, job->first_splats);
    stp_free(context, job->set_boxes);
    stp_free(context, (void*)(uintptr_t)job->seen);
    job->first_splats = NULL;
    job->set_boxes = NULL;
    job->seen = NULL;
}

static bool was_seen(const stp_capture_job* job, uint64_t splat)
{
    uint32_t word = atomic_load_explicit(&job->seen[splat / 32], memory_order_relaxed);
    return (word >> (splat & 31) & 1) != 0;
}

static void mark_seen(const stp_capture_job* job, uint64_t splat)
{
    assert(splat < job->first_splats[job->set_count]);
    if (!was_seen(job, splat)) {
        atomic_fetch_or_explicit(&job->seen[splat / 32], UINT32_C(1) << (splat & 31),
                                 memory_order_relaxed);
    }
}

// Inputs of the test whether centres are visible.
typedef struct sight {
    const stp_capture_job* job;
    const stp_capture_view* view;
    const stp_capture_band* band;
    const stp_raster_target* target;
    stp_set_placing placing;
    double row[3][3], at_zero[3]; ///< x, y, nearness per grid step
    double pixel, depth;          ///< scene units per pixel; nearness per scene unit
    double radius;                ///< scene units
    bool two_sided;               ///< splats facing away are tested, too
} sight;

static sight make_sight(const stp_capture_job* job, const stp_capture_band* band,
                        const stp_raster_target* target, size_t set)
{
    const stp_placed_set* placed = &job->sets[set];
    const stp_capture_view* view = &job->views[band->view];
    stp_affine placement = stp_capture_set_placement(job, set);
    sight s = {.job = job, .view = view, .band = band, .target = target};
    s.two_sided = placed->unknown_signs;
    s.placing = stp_set_placing_make(placed->splats, &placement);
    s.pixel = 1.0 / sqrt(stp_dotd(view->right, view->right));
    s.depth = sqrt(stp_dotd(view->depth, view->depth));
    s.radius = (double)placed->radius * stp_affine_stretch(&placed->transform);
    stp_vec3d zero = stp_affine_point(&placement, stp_to_double(placed->splats->origin));
    const stp_vec3d axes[3] = {view->right, view->down, view->depth};
    const double shifts[3] = {view->shift_x, view->shift_y, 1.5};
    for (int r = 0; r < 3; ++r) {
        s.at_zero[r] = stp_dotd(axes[r], zero) + shifts[r];
        for (int c = 0; c < 3; ++c) {
            stp_vec3d column = {placement.m[0][c], placement.m[1][c], placement.m[2][c]};
            s.row[r][c] = stp_dotd(axes[r], column) * (double)placed->splats->step;
        }
    }
    return s;
}

// Whether a splat's centre is unoccluded: its plane, at the pixel's centre, is not behind the
// surface the pixel shows.
static bool is_centre_visible(const sight* s, uint32_t splat)
{
    const uint16_t* value = s->placing.splats->positions + 3 * (size_t)splat;
    double at[3];
    for (int r = 0; r < 3; ++r) {
        at[r] = s->row[r][0] * (double)value[0] + s->row[r][1] * (double)value[1] +
                s->row[r][2] * (double)value[2] + s->at_zero[r];
    }
    if (!(at[0] >= 0.0 && at[0] < (double)s->view->width && at[1] >= (double)s->band->row_begin &&
          at[1] < (double)s->band->row_end)) {
        return false;
    }
    size_t column = (size_t)at[0], row = (size_t)at[1];
    assert(row - s->band->row_begin < s->target->height);
    uint64_t pixel = s->target->pixels[(row - s->band->row_begin) * s->target->stride + column];
    double seen = pixel != STP_RASTER_EMPTY ? (double)stp_raster_nearness(pixel) : 0.0;
    double reach = s->radius * s->depth;
    if (at[2] + (1.0 + DEPTH_TOLERANCE) * reach < seen) {
        return false;
    }
    stp_vec3d n = stp_set_normal(&s->placing, splat);
    double facing = stp_dotd(n, s->view->toward);
    if ((s->two_sided ? fabs(facing) : facing) < MIN_FACING) {
        return false;
    }
    double across = stp_dotd(n, s->view->right) * s->pixel * ((double)column + 0.5 - at[0]);
    double along = stp_dotd(n, s->view->down) * s->pixel * ((double)row + 0.5 - at[1]);
    double rise = -(across + along) * s->pixel / facing * s->depth;
    rise = rise > reach ? reach : rise < -reach ? -reach : rise;
    return at[2] + rise + DEPTH_TOLERANCE * reach >= seen;
}

// Whether a set's disks may reach into the band.
static bool reaches_band(const stp_capture_job* job, const stp_capture_band* band, size_t set)
{
    const stp_capture_view* view = &job->views[band->view];
    stp_boxd box = job->set_boxes[set];
    stp_vec3d centre = stp_subd(stp_scaled(stp_addd(box.min, box.max), 0.5), job->centre);
    stp_vec3d half = stp_scaled(stp_subd(box.max, box.min), 0.5);
    double middle = stp_dotd(view->down, centre) + view->shift_y;
    double reach = fabs(view->down.x) * half.x + fabs(view->down.y) * half.y +
                   fabs(view->down.z) * half.z + 1.0;
    return middle + reach >= (double)band->row_begin && middle - reach <= (double)band->row_end;
}

// The first covered pixel from `at` on, or `count`. Skips eight empty pixels at a time.
static size_t next_drawn(const stp_raster_target* target, size_t at, size_t count)
{
    _Static_assert(STP_RASTER_EMPTY == UINT64_MAX, "empty pixels are joined by and");
    const uint64_t* p = target->pixels;
    for (; at + 8 <= count; at += 8) {
        uint64_t half = p[at] & p[at + 1] & p[at + 2] & p[at + 3];
        if ((half & p[at + 4] & p[at + 5] & p[at + 6] & p[at + 7]) != STP_RASTER_EMPTY) {
            break;
        }
    }
    while (at < count && p[at] == STP_RASTER_EMPTY) {
        ++at;
    }
    return at;
}

// Splats that won pixels become candidates. If a disk covers no pixel centre, or its neighbours
// won all its pixels, its own centre is tested.
void stp_capture_take_splats(const stp_capture_job* job, const stp_capture_band* band,
                             const stp_raster_target* target, const uint64_t* primitives)
{
    if (job->set_count == 0) {
        return;
    }
    assert(target->stride == target->width && "rows without gaps: pixels are read as one row");
    uint64_t first = stp_capture_part_primitives(job);
    size_t count = (size_t)target->height * target->width;
    for (size_t i = next_drawn(target, 0, count); i < count; i = next_drawn(target, i + 1, count)) {
        uint64_t primitive = primitives != NULL ? primitives[i] : stp_raster_id(target->pixels[i]);
        if (primitive >= first) {
            mark_seen(job, primitive - first);
        }
    }
    for (size_t set = 0; set < job->set_count; ++set) {
        if (!reaches_band(job, band, set)) {
            continue;
        }
        sight s = make_sight(job, band, target, set);
        for (uint32_t i = 0; i < job->sets[set].prefix; ++i) {
            if (!was_seen(job, job->first_splats[set] + i) && is_centre_visible(&s, i)) {
                mark_seen(job, job->first_splats[set] + i);
            }
        }
    }
    // the remaining pixels belong to parts
    for (size_t i = next_drawn(target, 0, count); i < count; i = next_drawn(target, i + 1, count)) {
        uint64_t primitive = primitives != NULL ? primitives[i] : stp_raster_id(target->pixels[i]);
        if (primitive >= first) {
            target->pixels[i] = STP_RASTER_EMPTY;
        }
    }
}

static uint64_t word_count(const stp_capture_job* job)
{
    return job->first_splats[job->set_count] / 32 + 1;
}

static uint32_t word_at(const stp_capture_job* job, uint64_t word)
{
    return atomic_load_explicit(&job->seen[word], memory_order_relaxed);
}

uint64_t stp_capture_seen_count(const stp_capture_job* job)
{
    uint64_t sum = 0;
    for (uint64_t word = 0; word < word_count(job); ++word) {
        sum += (uint64_t)__builtin_popcount(word_at(job, word));
    }
    return sum;
}

typedef struct resolve_sets {
    const stp_capture_job* job;
    stp_candidates* out;
    uint64_t* starts; ///< candidate of the first visible splat of each task
} resolve_sets;

// The drawn part of a disk.
typedef struct drawn_part {
    float area; ///< fraction of the disk's area; its mean for disks with holes
    bool has_holes;
} drawn_part;

static drawn_part find_colour(const stp_splats* s, const stp_set_entries* look, uint32_t splat,
                              uint8_t rgba[4])
{
    const uint8_t* own = s->colors + 3 * (look->first + splat);
    const uint8_t* before = s->colors + 3 * (look->first_before + splat);
    float share = splat < look->before ? look->share : 1.0f;
    for (int k = 0; k < 3; ++k) {
        rgba[k] = own[k];
        if (share < 1.0f && before[k] != own[k]) {
            float from = stp_srgb8_to_linear(before[k]), to = stp_srgb8_to_linear(own[k]);
            rgba[k] = stp_linear_to_srgb8(from + (to - from) * share);
        }
    }
    uint8_t code = s->coverages[look->first + splat];
    float chance = stp_coverage_area(code), solid = code >= STP_COVERAGE_HALVES ? 1.0f : 0.0f;
    if (share < 1.0f) {
        uint8_t before_code = s->coverages[look->first_before + splat];
        float other = stp_coverage_area(before_code);
        chance = other + (chance - other) * share;
        solid *= before_code >= STP_COVERAGE_HALVES ? 1.0f : share;
    }
    // disks overlap, so together they cover more than the share; clipped disks have no holes
    float fraction = 1.0f - (1.0f - chance) * (1.0f - chance);
    fraction += (1.0f - fraction) * solid;
    float scaled = fraction * 255.0f + 0.5f;
    rgba[3] = scaled < 1.0f ? 1 : (uint8_t)scaled;
    return (drawn_part){chance, solid < 1.0f};
}

// The light normal as a member of a prefix, of length 0 to 1.
static stp_vec3d find_light(const stp_set_placing* placing, const stp_set_entries* look,
                            uint32_t splat)
{
    const int8_t* own = placing->splats->normals + 2 * (size_t)splat;
    stp_vec3d light = stp_to_double(stp_light_normal(&look->lights, own, splat));
    if (splat < look->before && look->share < 1.0f) {
        stp_vec3d before = stp_to_double(stp_light_normal(&look->lights_before, own, splat));
        light = stp_addd(before, stp_scaled(stp_subd(light, before), (double)look->share));
    }
    double length = sqrt(stp_dotd(light, light));
    return length > 0.0 ? stp_scaled(place_normal(placing, stp_scaled(light, 1.0 / length)), length)
                        : light;
}

// The set of a splat. Tests `set` first.
static size_t find_set(const stp_capture_job* job, uint64_t splat, size_t set)
{
    if (set < job->set_count && splat >= job->first_splats[set] &&
        splat < job->first_splats[set + 1]) {
        return set;
    }
    size_t low = 0, high = job->set_count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        *(splat >= job->first_splats[middle] ? &low : &high) = middle;
    }
    assert(splat >= job->first_splats[low] && splat < job->first_splats[low + 1]);
    return low;
}

// Disks of a placed set, and the surface area that a fully drawn one represents.
typedef struct set_area {
    double disk, whole;
} set_area;

static set_area find_area(const stp_placed_set* set)
{
    double scale = stp_affine_stretch(&set->transform), disk = (double)set->radius;
    double reach = disk - (double)set->splats->candidate_radius; // coverage radius
    reach = reach > 0.5 * disk ? reach : 0.5 * disk;
    disk *= scale, reach *= scale;
    return (set_area){STP_PI * disk * disk, STP_WHOLE_SHARE * STP_PI * reach * reach};
}

static void write_candidate(stp_candidates* out, size_t to, const stp_set_placing* placing,
                            const stp_set_entries* look, uint32_t splat, set_area area)
{
    stp_vec3 at = stp_to_float(stp_set_position(placing, splat));
    stp_vec3 normal = stp_to_float(stp_set_normal(placing, splat));
    memcpy(out->positions + 3 * to, &at, sizeof(at));
    memcpy(out->normals + 3 * to, &normal, sizeof(normal));
    if (out->light_normals != NULL) {
        stp_vec3 light = stp_to_float(find_light(placing, look, splat));
        memcpy(out->light_normals + 3 * to, &light, sizeof(light));
    }
    drawn_part drawn = find_colour(placing->splats, look, splat, out->colors + 4 * to);
    double own = drawn.has_holes ? stp_share_of_chance((double)drawn.area) * area.disk
                                 : (double)drawn.area * area.whole;
    assert(to >= out->count && !(own < 0.0));
    out->set_areas[to - out->count] = (float)(own < area.whole ? own : area.whole);
    out->materials[to] = placing->splats->materials[splat];
}

static void resolve_tasks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const resolve_sets* r = user;
    const stp_capture_job* job = r->job;
    uint64_t words = word_count(job);
    for (size_t task = begin; task < end; ++task) {
        uint64_t first = task * WORDS_PER_TASK, last = first + WORDS_PER_TASK;
        size_t to = (size_t)r->starts[task], set = SIZE_MAX;
        stp_set_placing placing = {0};
        stp_set_entries look = {0};
        set_area area = {0};
        for (uint64_t word = first; word < (last < words ? last : words); ++word) {
            for (uint32_t bits = word_at(job, word); bits != 0; bits &= bits - 1) {
                uint64_t splat = 32 * word + (uint64_t)__builtin_ctz(bits);
                size_t own = find_set(job, splat, set);
                if (own != set) {
                    set = own;
                    stp_affine placement = stp_capture_set_placement(job, set);
                    placing = stp_set_placing_make(job->sets[set].splats, &placement);
                    look = stp_set_entries_of(job->sets[set].splats, job->sets[set].prefix);
                    area = find_area(&job->sets[set]);
                }
                write_candidate(r->out, to++, &placing, &look,
                                (uint32_t)(splat - job->first_splats[set]), area);
            }
        }
    }
}

// Records the largest radius of the sets' disks; visible surface may be as far from a candidate.
static void note_radii(const stp_placed_set* sets, size_t count, stp_candidates* candidates)
{
    for (size_t i = 0; i < count; ++i) {
        float radius = (float)((double)sets[i].radius * stp_affine_stretch(&sets[i].transform));
        candidates->set_radius = stp_max(candidates->set_radius, radius);
    }
    double reach = (double)candidates->set_radius;
    candidates->surface_radius =
        candidates->surface_radius > reach ? candidates->surface_radius : reach;
}

stp_result stp_capture_resolve_sets(const stp_capture_job* job, stp_candidates* candidates)
{
    stp_context* context = job->scene->context;
    assert(candidates->set_areas == NULL && candidates->set_count == 0);
    uint64_t words = word_count(job);
    size_t tasks = (size_t)((words + WORDS_PER_TASK - 1) / WORDS_PER_TASK);
    resolve_sets r = {job, candidates, STP_NEW_ARRAY(context, uint64_t, tasks)};
    if (r.starts == NULL) {
        return stp_fail_memory(context);
    }
    candidates->set_areas = STP_NEW_ARRAY(context, float, stp_capture_seen_count(job) + 1);
    if (candidates->set_areas == NULL) {
        stp_free(context, r.starts);
        return stp_fail_memory(context);
    }
    uint64_t sum = candidates->count;
    for (uint64_t word = 0; word < words; ++word) {
        if (word % WORDS_PER_TASK == 0) {
            r.starts[word / WORDS_PER_TASK] = sum;
        }
        sum += (uint64_t)__builtin_popcount(word_at(job, word));
    }
    assert(sum <= job->room && "the columns have room for all");
    stp_parallel_for(context, tasks, 1, resolve_tasks, &r);
    stp_free(context, r.starts);
    candidates->set_count = (uint32_t)(sum - candidates->count);
    candidates->count = (uint32_t)sum;
    if (candidates->set_count != 0) {
        note_radii(job->sets, job->set_count, candidates);
    }
    return STP_OK;
}

typedef struct place_sets {
    const stp_placed_set* sets;
    stp_candidates* out;
    const size_t* starts; ///< candidate of each set's first splat
} place_sets;

static void place_whole_sets(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const place_sets* p = user;
    for (size_t i = begin; i < end; ++i) {
        const stp_placed_set* set = &p->sets[i];
        stp_affine placement = stp_affine_shifted(set->transform, p->out->origin);
        stp_set_placing placing = stp_set_placing_make(set->splats, &placement);
        stp_set_entries look = stp_set_entries_of(set->splats, set->prefix);
        set_area area = find_area(set);
        for (uint32_t k = 0; k < set->prefix; ++k) {
            write_candidate(p->out, p->starts[i] + k, &placing, &look, k, area);
        }
    }
}

stp_result stp_candidates_add_sets(stp_context* context, const stp_placed_set* sets,
                                   size_t set_count, stp_candidates* candidates)
{
    assert(candidates->set_areas == NULL && candidates->set_count == 0);
    size_t* starts = STP_NEW_ARRAY(context, size_t, set_count + 1);
    if (starts == NULL) {
        return stp_fail_memory(context);
    }
    size_t end = candidates->count;
    for (size_t i = 0; i < set_count; ++i) {
        starts[i] = end;
        end += sets[i].prefix;
    }
    candidates->set_areas = STP_NEW_ARRAY(context, float, end - candidates->count + 1);
    if (candidates->set_areas == NULL) {
        stp_free(context, starts);
        return stp_fail_memory(context);
    }
    assert(end <= UINT32_MAX);
    place_sets p = {sets, candidates, starts};
    stp_parallel_for(context, set_count, 1, place_whole_sets, &p);
    stp_free(context, starts);
    candidates->set_count = (uint32_t)(end - candidates->count);
    candidates->count = (uint32_t)end;
    note_radii(sets, set_count, candidates);
    return STP_OK;
}
