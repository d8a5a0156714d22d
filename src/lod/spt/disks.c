// SPDX-License-Identifier: MIT
#include "lod/spt/point_tree.h"

#include <assert.h>

enum {
    ROUNDS = 24, ///< iterations of moving the centre towards the farthest child
    SLABS = 16,  ///< directions in which widths are measured
};

// Cosine and sine of k / 16 of half a turn. Constants, because math libraries differ in the last
// bit.
static const double cosines[SLABS] = {
    1,
    0.98078528040323043,
    0.92387953251128674,
    0.83146961230254524,
    0.70710678118654757,
    0.55557023301960229,
    0.38268343236508984,
    0.19509032201612833,
    0,
    -0.19509032201612819,
    -0.38268343236508973,
    -0.55557023301960196,
    -0.70710678118654746,
    -0.83146961230254535,
    -0.92387953251128674,
    -0.98078528040323043,
};
static const double sines[SLABS] = {
    0,
    0.19509032201612825,
    0.38268343236508978,
    0.55557023301960218,
    0.70710678118654746,
    0.83146961230254524,
    0.92387953251128674,
    0.98078528040323043,
    1,
    0.98078528040323043,
    0.92387953251128674,
    0.83146961230254546,
    0.70710678118654757,
    0.55557023301960218,
    0.38268343236508989,
    0.19509032201612861,
};

// Axes of a disk's plane.
typedef struct frame {
    stp_vec3d across, along;
} frame;

// Two unit vectors perpendicular to a unit normal and to each other (Duff et al. 2017).
static frame make_frame(stp_vec3 normal)
{
    double x = (double)normal.x, y = (double)normal.y, z = (double)normal.z;
    assert(x != 0.0 || y != 0.0 || z != 0.0);
    double sign = z < 0.0 ? -1.0 : 1.0, a = -1.0 / (sign + z), b = x * y * a;
    return (frame){{1.0 + sign * x * x * a, sign * b, -sign * x}, {b, sign + y * y * a, -y}};
}

static bool is_sphere(const stp_tree_disk* disk)
{
    return stp_dot(disk->normal, disk->normal) == 0.0f;
}

// Projects an offset onto the plane of a normal; unchanged if the normal is zero.
static stp_vec3d flatten(stp_vec3d offset, stp_vec3 normal)
{
    stp_vec3d n = stp_to_double(normal);
    return stp_subd(offset, stp_scaled(n, stp_dotd(offset, n)));
}

// Centre of the smallest disk around two disks, which may be one of them.
static stp_vec3d join_two(stp_vec3d a, double ra, stp_vec3d b, double rb)
{
    stp_vec3d offset = stp_subd(b, a);
    double distance = stp_lengthd(offset);
    if (distance + rb <= ra) {
        return a;
    }
    if (distance + ra <= rb) {
        return b;
    }
    return stp_addd(a, stp_scaled(offset, 0.5 + 0.5 * (rb - ra) / distance));
}

// Children as arrays of coordinates, for vectorized loops.
typedef struct flat_children {
    uint32_t count;
    double x[STP_DISK_CHILDREN], y[STP_DISK_CHILDREN], z[STP_DISK_CHILDREN];
    double radii[STP_DISK_CHILDREN];
} flat_children;

static stp_vec3d place_of(const flat_children* f, uint32_t i)
{
    return (stp_vec3d){f->x[i], f->y[i], f->z[i]};
}

static inline void measure_extents(const flat_children* f, stp_vec3d center, uint32_t begin,
                                   double extents[STP_DISK_CHILDREN])
{
    for (uint32_t i = begin; i < begin + STP_DISK_CHILDREN / 2; ++i) {
        double x = f->x[i] - center.x, y = f->y[i] - center.y, z = f->z[i] - center.z;
        extents[i] = sqrt(x * x + y * y + z * z) + f->radii[i];
    }
}

// Maximum distance from a centre to the far side of a child, and that child.
static double max_extent(const flat_children* f, stp_vec3d center, uint32_t* farthest)
{
    assert(f->count > 0 && f->count <= STP_DISK_CHILDREN);
    double extents[STP_DISK_CHILDREN], maximum = -1.0;
    measure_extents(f, center, 0, extents);
    if (f->count > STP_DISK_CHILDREN / 2) {
        measure_extents(f, center, STP_DISK_CHILDREN / 2, extents);
    }
    for (uint32_t i = 0; i < f->count; ++i) {
        if (extents[i] > maximum) {
            maximum = extents[i];
            *farthest = i;
        }
    }
    return maximum;
}

/// Relative to the lower bound on the radius: the disk around the two farthest children
#define CLOSE_ENOUGH 1.005

// Begins with the disk around two distant children, which often encloses the others. Otherwise
// moves the centre towards the farthest child in decreasing steps (Badoiu and Clarkson 2003, for
// disks) and keeps the best centre.
static void find_enclosing(const flat_children* f, stp_vec3d* center)
{
    uint32_t first = 0, second = 0, farthest = 0;
    (void)max_extent(f, (stp_vec3d){0}, &first);
    (void)max_extent(f, place_of(f, first), &second);
    stp_vec3d at =
        join_two(place_of(f, first), f->radii[first], place_of(f, second), f->radii[second]);
    *center = at;
    double best = max_extent(f, at, &farthest);
    double apart = stp_lengthd(stp_subd(place_of(f, second), place_of(f, first)));
    double minimum = 0.5 * (apart + f->radii[first] + f->radii[second]) * CLOSE_ENOUGH;
    for (int round = 1; round <= ROUNDS && best > minimum; ++round) {
        stp_vec3d offset = stp_subd(place_of(f, farthest), at);
        double distance = stp_lengthd(offset);
        double step = distance > 0.0 ? fmin(best / (distance * (double)(round + 2)), 0.5) : 0.0;
        at = stp_addd(at, stp_scaled(offset, step));
        double reach = max_extent(f, at, &farthest);
        if (reach < best) {
            best = reach;
            *center = at;
        }
    }
}

stp_tree_disk stp_disk_enclose(const stp_tree_disk* children, const float* weights, uint32_t count)
{
    stp_vec3d middle = {0}, normal = {0};
    double sum = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        double weight = (double)weights[i];
        assert(weight > 0.0 && !(children[i].radius < 0.0f));
        middle = stp_addd(middle, stp_scaled(stp_to_double(children[i].center), weight));
        normal = stp_addd(normal, stp_scaled(stp_to_double(children[i].normal), weight));
        sum += weight;
    }
    middle = stp_scaled(middle, 1.0 / sum);
    stp_tree_disk disk = {.normal = {(float)normal.x, (float)normal.y, (float)normal.z}};
    // normals that cancel out have no direction
    bool turned = stp_lengthd(normal) > 1e-3 * sum;
    disk.normal = turned ? stp_normalize(disk.normal) : (stp_vec3){0};
    flat_children flat = {.count = count};
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3d at = flatten(stp_subd(stp_to_double(children[i].center), middle), disk.normal);
        flat.x[i] = at.x;
        flat.y[i] = at.y;
        flat.z[i] = at.z;
        flat.radii[i] = (double)children[i].radius;
    }
    stp_vec3d offset;
    uint32_t farthest;
    find_enclosing(&flat, &offset);
    stp_vec3d center = stp_addd(middle, offset);
    disk.center = (stp_vec3){(float)center.x, (float)center.y, (float)center.z};
    // far from the origin, rounding moves the centre by more than the radius
    offset = flatten(stp_subd(stp_to_double(disk.center), middle), disk.normal);
    disk.radius = (float)(max_extent(&flat, offset, &farthest) * (1.0 + 1e-6));
    assert(!(disk.radius < 0.0f));
    return disk;
}

// Extent of a child along a unit direction, on either side of its centre.
static double half_width(const stp_tree_disk* child, stp_vec3d direction)
{
    double turned = stp_dotd(stp_to_double(child->normal), direction);
    double part = 1.0 - turned * turned;
    return (double)child->radius * sqrt(part > 0.0 ? part : 0.0); // a sphere: its radius
}

// Width of all children along a direction.
static double width_along(const stp_tree_disk* disk, const stp_tree_disk* children, uint32_t count,
                          stp_vec3d direction)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3d offset = stp_subd(stp_to_double(children[i].center), stp_to_double(disk->center));
        double at = stp_dotd(offset, direction), half = half_width(&children[i], direction);
        low = at - half < low ? at - half : low;
        high = at + half > high ? at + half : high;
    }
    return high - low;
}

// Directions in the plane of a disk, one array per coordinate.
typedef struct slab_directions {
    double x[SLABS], y[SLABS], z[SLABS];
} slab_directions;

static void find_directions(stp_vec3 normal, slab_directions* d)
{
    frame f = make_frame(normal);
    for (int k = 0; k < SLABS; ++k) {
        d->x[k] = f.across.x * cosines[k] + f.along.x * sines[k];
        d->y[k] = f.across.y * cosines[k] + f.along.y * sines[k];
        d->z[k] = f.across.z * cosines[k] + f.along.z * sines[k];
    }
}

// Minimum of width_along() over SLABS directions in the disk's plane, in vectorized loops.
static double find_narrowest(const stp_tree_disk* disk, const stp_tree_disk* children,
                             uint32_t count)
{
    slab_directions d;
    double low[SLABS], high[SLABS];
    find_directions(disk->normal, &d);
    for (int k = 0; k < SLABS; ++k) {
        low[k] = HUGE_VAL;
        high[k] = -HUGE_VAL;
    }
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3d offset = stp_subd(stp_to_double(children[i].center), stp_to_double(disk->center));
        stp_vec3d n = stp_to_double(children[i].normal);
        double radius = (double)children[i].radius;
        for (int k = 0; k < SLABS; ++k) {
            double at = offset.x * d.x[k] + offset.y * d.y[k] + offset.z * d.z[k];
            double turned = n.x * d.x[k] + n.y * d.y[k] + n.z * d.z[k];
            double part = 1.0 - turned * turned;
            double half = radius * sqrt(part > 0.0 ? part : 0.0);
            low[k] = at - half < low[k] ? at - half : low[k];
            high[k] = at + half > high[k] ? at + half : high[k];
        }
    }
    double narrowest = HUGE_VAL;
    for (int k = 0; k < SLABS; ++k) {
        narrowest = high[k] - low[k] < narrowest ? high[k] - low[k] : narrowest;
    }
    return narrowest;
}

stp_disk_error stp_disk_measure(const stp_tree_disk* disk, const stp_tree_disk* children,
                                uint32_t count)
{
    assert(count > 0 && "the width of nothing is infinite");
    double diameter = 2.0 * (double)disk->radius;
    if (is_sphere(disk)) {
        return (stp_disk_error){(float)diameter, (float)diameter, (float)diameter};
    }
    double perpendicular = width_along(disk, children, count, stp_to_double(disk->normal));
    double narrowest = find_narrowest(disk, children, count);
    double tangential = fmax(diameter - narrowest, 0.0);
    double geometric = sqrt(perpendicular * perpendicular + tangential * tangential);
    return (stp_disk_error){(float)perpendicular, (float)tangential, (float)geometric};
}
