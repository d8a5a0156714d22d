// SPDX-License-Identifier: MIT
#include "lod/spt/disks.h"

enum {
    ROUNDS = 24, ///< of moving the centre towards the child that reaches farthest
    SLABS = 16,  ///< directions in which widths are measured
};

// Cosine and sine of k / 16 of half a turn; constants, because libraries differ in the last bit.
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

// Where children lie in the plane of a disk, or in space.
typedef struct frame {
    stp_vec3d across, along;
} frame;

// Two directions that are perpendicular to a unit normal and to each other (Duff et al. 2017).
static frame make_frame(stp_vec3 normal)
{
    double x = (double)normal.x, y = (double)normal.y, z = (double)normal.z;
    double sign = z < 0.0 ? -1.0 : 1.0, a = -1.0 / (sign + z), b = x * y * a;
    return (frame){{1.0 + sign * x * x * a, sign * b, -sign * x}, {b, sign + y * y * a, -y}};
}

static bool is_sphere(const stp_disk* disk)
{
    return stp_dot(disk->normal, disk->normal) == 0.0f;
}

// What is left of an offset in the plane of a normal; all of it where the normal is zero.
static stp_vec3d flatten(stp_vec3d offset, stp_vec3 normal)
{
    stp_vec3d n = stp_to_double(normal);
    return stp_subd(offset, stp_scaled(n, stp_dotd(offset, n)));
}

// The centre of the smallest disk around two, which may be one of them.
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

// Children by coordinate, so that several are looked at together.
typedef struct flat_children {
    uint32_t count;
    double x[STP_DISK_CHILDREN], y[STP_DISK_CHILDREN], z[STP_DISK_CHILDREN];
    double radii[STP_DISK_CHILDREN];
} flat_children;

static stp_vec3d place_of(const flat_children* f, uint32_t i)
{
    return (stp_vec3d){f->x[i], f->y[i], f->z[i]};
}

static inline void find_reaches(const flat_children* f, stp_vec3d center, uint32_t begin,
                                double reaches[STP_DISK_CHILDREN])
{
    for (uint32_t i = begin; i < begin + STP_DISK_CHILDREN / 2; ++i) {
        double x = f->x[i] - center.x, y = f->y[i] - center.y, z = f->z[i] - center.z;
        reaches[i] = sqrt(x * x + y * y + z * z) + f->radii[i];
    }
}

// How far the children reach from a centre, and which one does.
static double reach_from(const flat_children* f, stp_vec3d center, uint32_t* farthest)
{
    double reaches[STP_DISK_CHILDREN], most = -1.0;
    find_reaches(f, center, 0, reaches);
    if (f->count > STP_DISK_CHILDREN / 2) {
        find_reaches(f, center, STP_DISK_CHILDREN / 2, reaches);
    }
    for (uint32_t i = 0; i < f->count; ++i) {
        if (reaches[i] > most) {
            most = reaches[i];
            *farthest = i;
        }
    }
    return most;
}

#define CLOSE_ENOUGH 1.005 // times the least radius that any disk around two of the children has

// Begins with the disk around two children that reach far, which often holds the others. Else it is moved towards the one that
// reaches farthest by less and less (Badoiu and Clarkson 2003, for disks); the best centre on the way is kept.
static void find_enclosing(const flat_children* f, stp_vec3d* center)
{
    uint32_t first = 0, second = 0, farthest = 0;
    (void)reach_from(f, (stp_vec3d){0}, &first);
    (void)reach_from(f, place_of(f, first), &second);
    stp_vec3d at =
        join_two(place_of(f, first), f->radii[first], place_of(f, second), f->radii[second]);
    *center = at;
    double best = reach_from(f, at, &farthest);
    double apart = stp_lengthd(stp_subd(place_of(f, second), place_of(f, first)));
    double least = 0.5 * (apart + f->radii[first] + f->radii[second]) * CLOSE_ENOUGH;
    for (int round = 1; round <= ROUNDS && best > least; ++round) {
        stp_vec3d offset = stp_subd(place_of(f, farthest), at);
        double distance = stp_lengthd(offset);
        double step = distance > 0.0 ? fmin(best / (distance * (double)(round + 2)), 0.5) : 0.0;
        at = stp_addd(at, stp_scaled(offset, step));
        double reach = reach_from(f, at, &farthest);
        if (reach < best) {
            best = reach;
            *center = at;
        }
    }
}

stp_disk stp_disk_enclose(const stp_disk* children, const float* weights, uint32_t count)
{
    stp_vec3d middle = {0}, normal = {0};
    double sum = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        double weight = (double)weights[i];
        middle = stp_addd(middle, stp_scaled(stp_to_double(children[i].center), weight));
        normal = stp_addd(normal, stp_scaled(stp_to_double(children[i].normal), weight));
        sum += weight;
    }
    middle = stp_scaled(middle, 1.0 / sum);
    stp_disk disk = {.normal = {(float)normal.x, (float)normal.y, (float)normal.z}};
    // normals that cancel each other out point nowhere
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
    // far from the origin the centre is rounded by more than a disk is wide
    offset = flatten(stp_subd(stp_to_double(disk.center), middle), disk.normal);
    disk.radius = (float)(reach_from(&flat, offset, &farthest) * (1.0 + 1e-6));
    return disk;
}

// How far a child reaches along a direction of unit length, on either side of its centre.
static double half_width(const stp_disk* child, stp_vec3d direction)
{
    double turned = stp_dotd(stp_to_double(child->normal), direction);
    double part = 1.0 - turned * turned;
    return (double)child->radius * sqrt(part > 0.0 ? part : 0.0); // of a sphere all of its radius
}

// How much room the children take along a direction.
static double width_along(const stp_disk* disk, const stp_disk* children, uint32_t count,
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

// Directions in the plane of a disk, by coordinate.
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

// The least of width_along() in all directions, several of which are looked at together.
static double find_narrowest(const stp_disk* disk, const stp_disk* children, uint32_t count)
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

stp_disk_error stp_disk_measure(const stp_disk* disk, const stp_disk* children, uint32_t count)
{
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
