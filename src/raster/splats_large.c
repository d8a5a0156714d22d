// SPDX-License-Identifier: MIT
// Disks close to the eye or hundreds of pixels wide: intersects each pixel's ray with the plane in
// double precision.
#include "base/splats/octahedral.h"
#include "raster/splats_kernel.h"

#include <assert.h>

typedef struct large_disk {
    double center[3], normal[3], radius; ///< in view units
    double unit;                         ///< object-space unit, in view units
    double right, down;                  ///< pixel of the view axis
    double scale;                        ///< pixels per unit of x/z, or per unit
    double nearness;                     ///< nearness times z; parallel: at the centre
    double slope;                        ///< nearness per unit of z, parallel
    double rim, behind; ///< how far the rim, and a disk seen from behind, lie behind the plane
    double left, top;   ///< parallel: pixel of x = 0, y = 0
    bool parallel;
    double across[3], low, high; ///< clipped disk: low <= across . offset <= high
    bool is_clipped;
    double smaller[3], stretch; ///< ellipse: unit direction of its smaller radius, and its stretch
} large_disk;

static double row_dot(const float row[4], const double p[3])
{
    return (double)row[0] * p[0] + (double)row[1] * p[1] + (double)row[2] * p[2];
}

static void object_position(const stp_raster_splats* splats, uint32_t index, double p[3])
{
    size_t at = 3 * (size_t)index;
    const double origin[3] = {(double)splats->origin.x, (double)splats->origin.y,
                              (double)splats->origin.z};
    for (size_t k = 0; k < 3; ++k) {
        p[k] = splats->positions != NULL
                   ? origin[k] + (double)splats->step * (double)splats->positions[at + k]
                   : (double)splats->points[at + k];
    }
}

/// Transforms a direction in a splat's plane, given by its disk's axes, to view space. The length
/// becomes one object-space unit (large_disk.unit).
static void turn_direction(const stp_splat_frame* frame, uint32_t index, float across, float along,
                           double out[3])
{
    const int8_t* normal = frame->splats->normals + 2 * (size_t)index;
    stp_disk_axes axes = stp_disk_axes_of((float)normal[0], (float)normal[1]);
    double d[3] = {(double)(across * axes.x.x + along * axes.y.x),
                   (double)(across * axes.x.y + along * axes.y.y),
                   (double)(across * axes.x.z + along * axes.y.z)};
    for (int k = 0; k < 3; ++k) {
        out[k] = row_dot(frame->camera->view[k], d);
    }
}

/// Clipping lines of a disk.
static void clip_large(const stp_splat_frame* frame, uint32_t index, uint8_t code, large_disk* disk)
{
    stp_disk_clip clip = stp_coverage_clip(code);
    turn_direction(frame, index, clip.across, clip.along, disk->across);
    for (int k = 0; k < 3; ++k) {
        disk->across[k] = disk->across[k] / disk->radius / disk->unit;
    }
    disk->is_clipped = true;
    disk->low = (double)clip.low;
    disk->high = (double)clip.high;
}

/// The minor axis of an ellipse.
static void stretch_large(const stp_splat_frame* frame, uint32_t index, large_disk* disk)
{
    uint32_t code = frame->splats->shapes[index];
    disk->stretch = (double)stp_shape_stretch(code);
    if (frame->splats->normals == NULL || !(disk->stretch > 0.0)) {
        return;
    }
    stp_shape_axis axis = stp_shape_smaller(code);
    turn_direction(frame, index, axis.along_x, axis.along_y, disk->smaller);
    for (int k = 0; k < 3; ++k) {
        disk->smaller[k] /= disk->unit;
    }
}

static large_disk make_disk(const stp_splat_frame* frame, uint32_t index, int32_t halvings)
{
    assert(index >= frame->splats->begin && index < frame->splats->end);
    const stp_raster_camera* camera = frame->camera;
    large_disk disk = {.scale = (double)camera->pixel_scale, .parallel = camera->parallel};
    double p[3], vz[3];
    object_position(frame->splats, index, p);
    for (int k = 0; k < 3; ++k) {
        disk.center[k] = row_dot(camera->view[k], p) + (double)camera->view[k][3];
        vz[k] = (double)camera->view[2][k];
    }
    double square = vz[0] * vz[0] + vz[1] * vz[1] + vz[2] * vz[2];
    disk.unit = sqrt(square);
    disk.radius = (double)frame->splats->radius * disk.unit;
    if (frame->splats->shapes != NULL) {
        disk.radius *= (double)stp_shape_radius(frame->splats->shapes[index] & 0xFFFu);
        stretch_large(frame, index, &disk);
    } else {
        disk.radius *= (double)splat_growth(frame->splats, index);
    }
    disk.radius = ldexp(disk.radius, -halvings);
    if (frame->splats->normals != NULL) {
        const int8_t* code = frame->splats->normals + 2 * (size_t)index;
        stp_vec3 n = stp_octahedral_decode(code[0], code[1]);
        double normal[3] = {(double)n.x, (double)n.y, (double)n.z};
        for (int k = 0; k < 3; ++k) {
            disk.normal[k] = row_dot(camera->view[k], normal);
        }
    } else {
        disk.normal[0] = disk.parallel ? 0.0 : disk.center[0];
        disk.normal[1] = disk.parallel ? 0.0 : disk.center[1];
        disk.normal[2] = disk.parallel ? 1.0 : disk.center[2];
    }
    double towards = disk.parallel
                         ? disk.normal[2]
                         : disk.normal[0] * disk.center[0] + disk.normal[1] * disk.center[1] +
                               disk.normal[2] * disk.center[2];
    bool is_behind = frame->splats->normals != NULL && towards > 0.0;
    disk.rim = (double)frame->rim_depth * disk.radius;
    disk.behind = is_behind ? (double)frame->back_depth * disk.radius : 0.0;
    const stp_raster_matrix* m = &camera->matrix;
    double n_at = row_dot(m->m[2], p) + (double)m->m[2][3];
    if (disk.parallel) {
        disk.slope = row_dot(m->m[2], vz) / square;
        disk.nearness = n_at;
        disk.left = row_dot(m->m[0], p) + (double)m->m[0][3] - disk.center[0] * disk.scale;
        disk.top = row_dot(m->m[1], p) + (double)m->m[1][3] - disk.center[1] * disk.scale;
    } else {
        double factor = row_dot(m->m[3], vz) / square;
        disk.nearness = n_at / factor;
        disk.right = row_dot(m->m[0], vz) / square / factor;
        disk.down = row_dot(m->m[1], vz) / square / factor;
    }
    return disk;
}

/// Intersects the ray through (x, y) with the disk; false if they do not meet.
static bool intersect(const large_disk* disk, double x, double y, double* nearness)
{
    const double* c = disk->center;
    const double* n = disk->normal;
    double point[3];
    if (disk->parallel) {
        point[0] = (x - disk->left) / disk->scale;
        point[1] = (y - disk->top) / disk->scale;
        double up = n[0] * (point[0] - c[0]) + n[1] * (point[1] - c[1]);
        point[2] = c[2] - up / n[2];
    } else {
        double dx = (x - disk->right) / disk->scale, dy = (y - disk->down) / disk->scale;
        double t = (n[0] * c[0] + n[1] * c[1] + n[2] * c[2]) / (n[0] * dx + n[1] * dy + n[2]);
        if (!(t > 0.0)) {
            return false;
        }
        point[0] = t * dx;
        point[1] = t * dy;
        point[2] = t;
    }
    double square = 0.0, across = 0.0;
    for (int k = 0; k < 3; ++k) {
        square += (point[k] - c[k]) * (point[k] - c[k]);
        across += (point[k] - c[k]) * disk->across[k];
    }
    if (disk->stretch > 0.0) {
        double smaller = 0.0;
        for (int k = 0; k < 3; ++k) {
            smaller += (point[k] - c[k]) * disk->smaller[k];
        }
        square += disk->stretch * (smaller * smaller);
    }
    bool kept = !disk->is_clipped || (across >= disk->low && across <= disk->high);
    double limit = disk->radius * disk->radius;
    double z = point[2] + disk->behind + disk->rim * (square / limit);
    *nearness = disk->parallel ? disk->nearness + disk->slope * (z - c[2]) : disk->nearness / z;
    return square <= limit && kept;
}

/// First and last + 1 pixel that the disk's bounding ball may touch along one axis, within [low,
/// high).
static void reach(double center, double z, double radius, double scale, double middle, int32_t low,
                  int32_t high, int32_t* begin, int32_t* end)
{
    *begin = low;
    *end = high;
    if (z - radius <= 0.05 * radius) {
        return; // the ball contains the eye: any pixel
    }
    double a = (center - radius) / (center > radius ? z + radius : z - radius);
    double b = (center + radius) / (center < -radius ? z + radius : z - radius);
    double first = floor(middle + scale * a - 1.0), last = ceil(middle + scale * b + 1.0);
    *begin = !(first > (double)low) ? low : first > (double)high ? high : (int32_t)first;
    *end = !(last < (double)high) ? high : last < (double)low ? low : (int32_t)last;
}

static splat_box disk_box(const stp_splat_frame* frame, const large_disk* disk)
{
    splat_box box;
    const double* c = disk->center;
    double z = disk->parallel ? 1.0 : c[2];
    int32_t width = (int32_t)frame->target->width;
    if (disk->parallel) { // a perspective without depth: ignore the ball's z extent
        double r = disk->radius * disk->scale;
        double x = disk->left + disk->scale * c[0], y = disk->top + disk->scale * c[1];
        double low[2] = {x - r - 1.0, y - r - 1.0}, high[2] = {x + r + 2.0, y + r + 2.0};
        double edge[4] = {0.0, (double)width, (double)frame->row_begin, (double)frame->row_end};
        for (int k = 0; k < 2; ++k) {
            low[k] = low[k] > edge[2 * k] ? low[k] : edge[2 * k];
            low[k] = low[k] < edge[2 * k + 1] ? low[k] : edge[2 * k + 1];
            high[k] = high[k] < edge[2 * k + 1] ? high[k] : edge[2 * k + 1];
            high[k] = high[k] > edge[2 * k] ? high[k] : edge[2 * k];
        }
        return (splat_box){(int32_t)low[0], (int32_t)low[1], (int32_t)high[0], (int32_t)high[1]};
    }
    reach(c[0], z, disk->radius, disk->scale, disk->right, 0, width, &box.x0, &box.x1);
    reach(c[1], z, disk->radius, disk->scale, disk->down, frame->row_begin, frame->row_end, &box.y0,
          &box.y1);
    return box;
}

/// The pixel that holds the centre, perhaps outside the picture; -1 if it is behind the eye.
static void center_pixel(const large_disk* disk, double* x, double* y)
{
    const double* c = disk->center;
    *x = disk->parallel ? disk->left + disk->scale * c[0] : disk->right + disk->scale * c[0] / c[2];
    *y = disk->parallel ? disk->top + disk->scale * c[1] : disk->down + disk->scale * c[1] / c[2];
    bool ahead = disk->parallel || c[2] > 0.0;
    *x = ahead ? floor(*x) : -1.0;
    *y = ahead ? floor(*y) : -1.0;
}

uint64_t stp_splats_draw_large(const stp_splat_frame* frame, uint32_t index)
{
    uint32_t part = splat_part(frame->splats, index);
    uint32_t clip = part > SPLAT_CLIP ? part - SPLAT_CLIP : 0;
    part = clip != 0 ? 255 : part;
    int32_t halvings = (int32_t)splat_halvings(part); // the disk is large, so enough is left
    large_disk disk = make_disk(frame, index, halvings);
    if (clip != 0 && frame->splats->normals != NULL) {
        clip_large(frame, index, (uint8_t)clip, &disk);
    }
    splat_box box = disk_box(frame, &disk);
    assert(box.x0 >= 0 && box.x1 <= (int32_t)frame->target->width && box.y0 >= frame->row_begin &&
           box.y1 <= frame->row_end && "pixels of the target");
    uint32_t coverage = splat_coverage(frame->splats, part, halvings);
    double limit = (double)frame->nearness_limit, center_x, center_y;
    center_pixel(&disk, &center_x, &center_y);
    int32_t whole_x = (int32_t)fmin(fmax(center_x, -1e6), 1e6);
    int32_t whole_y = (int32_t)fmin(fmax(center_y, -1e6), 1e6);
    uint64_t fragments = 0;
    for (int32_t y = box.y0; y < box.y1; ++y) {
        uint64_t* row = frame->target->pixels + (size_t)y * frame->target->stride;
        for (int32_t x = box.x0; x < box.x1; ++x) {
            double nearness;
            bool in = intersect(&disk, (double)x + 0.5, (double)y + 0.5, &nearness);
            if (!in || !(nearness > 0.0) || nearness > limit) {
                continue;
            }
            if (frame->glass != NULL) {
                fragments += stp_transparent_store(frame, index, x, y, (float)nearness);
                continue;
            }
            if (coverage < 255 &&
                !splat_has_fragment(coverage, frame->seed + index, x - whole_x, y - whole_y)) {
                continue;
            }
            splat_store(&row[x], stp_raster_pixel((float)nearness, frame->first_id + index));
            fragments += 1;
        }
    }
    return fragments;
}
