// SPDX-License-Identifier: MIT
#include "lab/decimate/subsample_attempt.h"

#include <assert.h>

enum {
    ROUNDS = 4,        ///< rounds of assigning points and moving splats
    CENTER_STEPS = 48, ///< towards the centre of the smallest circle around points
};
#define RATIO_MAX 4.0f

/// A splat while it is fitted. Its plane stays that of the candidate, so no distance grows beyond
/// the tolerance.
typedef struct shape {
    stp_vec3d center, x, y, normal;
    double ratio,
        reach; ///< radius of the circle around the points, with distances along y scaled by `ratio`
    double major, minor;
} shape;

typedef struct fit {
    const stp_subsample_choice* choice;
    shape* shapes;    ///< one per chosen candidate
    uint32_t* owners; ///< per point: index among the chosen
    size_t* starts;   ///< per chosen candidate, start of its points in `owned`; and the end
    uint32_t* owned;  ///< points, by owner
} fit;

static double measure(const fit* f, const shape* s, uint32_t point)
{
    stp_vec3d p = stp_to_double(stp_subsample_position(f->choice->field, point));
    stp_vec3d d = stp_subd(p, s->center);
    double u = stp_dotd(d, s->x), v = stp_dotd(d, s->y) * s->ratio;
    return u * u + v * v;
}

/// Assigns each point to the splat with the nearest centre, relative to the splat's size.
static void assign_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    const fit* f = user;
    const stp_cover_problem* p = f->choice->problem;
    (void)worker;
    for (size_t point = begin; point < end; ++point) {
        double minimum = 0.0;
        uint32_t owner = UINT32_MAX;
        for (size_t i = p->set_starts[point]; i < p->set_starts[point + 1]; ++i) {
            uint32_t place = f->choice->cover->places[p->sets[i]];
            if (place != UINT32_MAX) {
                const shape* s = &f->shapes[place];
                double share = measure(f, s, (uint32_t)point) / (s->reach * s->reach);
                if (owner == UINT32_MAX || share < minimum || (share == minimum && place < owner)) {
                    minimum = share;
                    owner = place;
                }
            }
        }
        assert(owner < f->choice->cover->count && "the cover leaves out no point");
        f->owners[point] = owner;
    }
}

static void list_owned(const fit* f)
{
    uint32_t count = f->choice->cover->count, points = f->choice->field->count;
    for (uint32_t i = 0; i < count + 2; ++i) {
        f->starts[i] = 0;
    }
    for (uint32_t i = 0; i < points; ++i) {
        f->starts[f->owners[i] + 2]++;
    }
    for (uint32_t i = 2; i < count + 2; ++i) {
        f->starts[i] += f->starts[i - 1];
    }
    for (uint32_t i = 0; i < points; ++i) {
        f->owned[f->starts[f->owners[i] + 1]++] = i;
    }
    assert(f->starts[0] == 0 && f->starts[count] == points);
}

/// Moves a shape to the centre of the smallest circle around its points (Badoiu and Clarkson 2003),
/// and measures it.
static void center_shape(const fit* f, shape* s, const uint32_t* points, uint32_t count)
{
    const stp_subsample_field* field = f->choice->field;
    assert(count > 0 && s->ratio > 0.0);
    shape best = *s;
    double low = 0.0, high = 0.0;
    for (int step = 1; step <= CENTER_STEPS; ++step) {
        uint32_t far = 0;
        double maximum = -1.0;
        for (uint32_t i = 0; i < count; ++i) {
            double square = measure(f, s, points[i]);
            far = square > maximum ? i : far;
            maximum = square > maximum ? square : maximum;
        }
        if (step == 1 || maximum < best.reach * best.reach) {
            best = *s;
            best.reach = sqrt(maximum);
        }
        stp_vec3d d =
            stp_subd(stp_to_double(stp_subsample_position(field, points[far])), s->center);
        d = stp_subd(d, stp_scaled(s->normal, stp_dotd(d, s->normal)));
        s->center = stp_addd(s->center, stp_scaled(d, 1.0 / (step + 1)));
    }
    best.major = best.minor = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3d p = stp_to_double(stp_subsample_position(field, points[i]));
        double height = stp_dotd(stp_subd(p, best.center), best.normal);
        double margin = (double)field->margins[points[i]];
        double distance = sqrt(measure(f, &best, points[i]));
        low = i == 0 || height < low ? height : low;
        high = i == 0 || height > high ? height : high;
        best.major = fmax(best.major, distance + margin);
        best.minor = fmax(best.minor, distance / best.ratio + margin);
    }
    best.center = stp_addd(best.center, stp_scaled(best.normal, 0.5 * (low + high)));
    best.reach = best.major;
    *s = best;
}

/// Turns a shape so that its axes are those of its points' scatter.
static void turn_shape(const fit* f, shape* s, const uint32_t* points, uint32_t count)
{
    const stp_subsample_field* field = f->choice->field;
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0, pad = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3d d = stp_subd(stp_to_double(stp_subsample_position(field, points[i])), s->center);
        double u = stp_dotd(d, s->x), v = stp_dotd(d, s->y),
               margin = (double)field->margins[points[i]];
        x += u;
        y += v;
        xx += u * u;
        xy += u * v;
        yy += v * v;
        pad += 0.25 * margin * margin; // scatter of a disk
    }
    double n = (double)count;
    xx += pad - x * x / n;
    xy -= x * y / n;
    yy += pad - y * y / n;
    double half = 0.5 * (xx - yy), root = sqrt(half * half + xy * xy), mean = 0.5 * (xx + yy);
    double along = half >= 0.0 ? half + root : xy, beside = half >= 0.0 ? xy : root - half;
    double length = sqrt(along * along + beside * beside);
    const double maximum = (double)(RATIO_MAX * RATIO_MAX);
    if (!(mean > 0.0) || !(length > 0.0)) {
        s->ratio = 1.0;
        return;
    }
    stp_vec3d major = stp_addd(stp_scaled(s->x, along / length), stp_scaled(s->y, beside / length));
    s->center = stp_addd(s->center, stp_addd(stp_scaled(s->x, x / n), stp_scaled(s->y, y / n)));
    s->x = major;
    s->y = stp_crossd(s->normal, major);
    s->ratio = mean + root > maximum * (mean - root) ? (double)RATIO_MAX
                                                     : sqrt((mean + root) / (mean - root));
}

static void move_shapes(size_t begin, size_t end, uint32_t worker, void* user)
{
    const fit* f = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const uint32_t* points = f->owned + f->starts[i];
        uint32_t count = (uint32_t)(f->starts[i + 1] - f->starts[i]);
        if (count > 0) {
            shape kept = f->shapes[i], turned = kept;
            center_shape(f, &kept, points, count);
            turn_shape(f, &turned, points, count);
            center_shape(f, &turned, points, count);
            bool smaller = turned.major * turned.minor < kept.major * kept.minor;
            f->shapes[i] = smaller ? turned : kept;
        }
    }
}

static bool holds(const fit* f, const shape* s, uint32_t point)
{
    stp_vec3d p = stp_to_double(stp_subsample_position(f->choice->field, point));
    stp_vec3d d = stp_subd(p, s->center);
    double u = stp_dotd(d, s->x) / s->major, v = stp_dotd(d, s->y) / s->minor;
    return u * u + v * v <= 1.0;
}

/// The mean colour of the candidate's points that are still in its splat.
static void mix_color(const fit* f, uint32_t place, uint8_t color[3])
{
    const stp_subsample_candidates* c = f->choice->candidates;
    const stp_subsample_color* colors = f->choice->field->colors;
    uint32_t set = f->choice->cover->chosen[place];
    double sum[3] = {0}, count = 0.0;
    for (size_t i = c->starts[set]; i < c->starts[set + 1]; ++i) {
        uint32_t point = c->members[i];
        if (f->owners[point] == place || holds(f, &f->shapes[place], point)) {
            for (int k = 0; k < 3; ++k) {
                sum[k] += (double)colors[point].sum[k];
            }
            count += (double)colors[point].count;
        }
    }
    stp_subsample_color all = {{(float)sum[0], (float)sum[1], (float)sum[2]}, (float)count};
    stp_subsample_mean_color(&all, color);
}

static void begin_shapes(const fit* f)
{
    const stp_cover* cover = f->choice->cover;
    for (uint32_t i = 0; i < cover->count; ++i) {
        const stp_subsample_candidate* c = &f->choice->candidates->shapes[cover->chosen[i]];
        stp_vec3d normal = stp_to_double(c->normal), axis = stp_to_double(c->axis);
        f->shapes[i] = (shape){.center = stp_to_double(c->center),
                               .normal = normal,
                               .x = axis,
                               .y = stp_crossd(normal, axis),
                               .ratio = (double)c->ratio,
                               .reach = (double)c->major,
                               .major = (double)c->major,
                               .minor = (double)c->minor};
    }
}

stp_result stp_subsample_fit(stp_context* context, const stp_subsample_choice* choice,
                             stp_ellipse* ellipses, uint8_t* colors, uint32_t* count)
{
    size_t points = choice->field->count, splats = choice->cover->count;
    fit f = {.choice = choice,
             .shapes = STP_NEW_ARRAY(context, shape, splats + 1),
             .owners = STP_NEW_ARRAY(context, uint32_t, points + 1),
             .starts = STP_NEW_ARRAY(context, size_t, splats + 2),
             .owned = STP_NEW_ARRAY(context, uint32_t, points + 1)};
    bool made = f.shapes != NULL && f.owners != NULL && f.starts != NULL && f.owned != NULL;
    *count = 0;
    if (made) {
        begin_shapes(&f);
    }
    for (int round = 0; made && round < ROUNDS; ++round) {
        stp_parallel_for(context, points, 1024, assign_points, &f);
        list_owned(&f);
        stp_parallel_for(context, splats, 16, move_shapes, &f);
    }
    for (uint32_t i = 0; made && i < splats; ++i) {
        const shape* s = &f.shapes[i];
        if (f.starts[i + 1] > f.starts[i]) {
            uint8_t* color = colors + 3 * (size_t)*count;
            color[0] = color[1] = color[2] = 255;
            if (choice->field->colors != NULL) {
                mix_color(&f, i, color);
            }
            bool wide = s->major >= s->minor;
            stp_vec3d axis = stp_scaled(wide ? s->x : s->y, wide ? s->major : s->minor);
            ellipses[(*count)++] =
                (stp_ellipse){stp_to_float(s->center), stp_to_float(s->normal), stp_to_float(axis),
                              (float)(wide ? s->minor : s->major)};
        }
    }
    stp_free(context, f.shapes);
    stp_free(context, f.owners);
    stp_free(context, f.starts);
    stp_free(context, f.owned);
    return made ? STP_OK : stp_fail_memory(context);
}
