// SPDX-License-Identifier: MIT
#include "lab/scenes/trees.h"

#include "lab/scenes/scene_random.h"
#include "lab/scenes/solids.h"
#include "lab/scenes/trigonometry.h"

#include <assert.h>

enum { MOST_LEVELS = 4, MOST_SIDES = 10 };

typedef enum crown_shape { CROWN_ROUND, CROWN_CONE, CROWN_COLUMN, CROWN_UMBRELLA } crown_shape;

typedef struct tree_kind {
    const char* name;
    uint32_t triangles;
    double height, trunk_radius;
    double bare;   ///< share of the trunk below the first branch
    double spread; ///< length of the longest branch, relative to the height
    double rise;   ///< sine of the angle between branches and the ground
    double droop;  ///< sag along the branch
    crown_shape crown;
    int levels;                ///< levels of branches, the trunk included
    int children[MOST_LEVELS]; ///< children of a branch of each level
    double leaf_length, leaf_width;
    double bark[3], leaf[3]; ///< linear colours
} tree_kind;

// Counts are those of the benchmark's terrain: 40k to 70k each, so that 30,000 trees with the tiles
// and roads total 1.74 G triangles (Brandt et al. 2019, Table 1).
static const tree_kind kinds[TREE_KINDS] = {
    {"oak",
     69800,
     14.0,
     0.42,
     0.22,
     0.46,
     0.45,
     0.10,
     CROWN_ROUND,
     4,
     {26, 8, 6, 0},
     0.34,
     0.24,
     {0.085, 0.060, 0.042},
     {0.075, 0.150, 0.030}},
    {"birch",
     52400,
     16.0,
     0.20,
     0.30,
     0.26,
     0.75,
     0.30,
     CROWN_ROUND,
     4,
     {34, 6, 5, 0},
     0.26,
     0.20,
     {0.520, 0.500, 0.460},
     {0.150, 0.230, 0.050}},
    {"spruce",
     64600,
     22.0,
     0.30,
     0.08,
     0.20,
     -0.10,
     0.10,
     CROWN_CONE,
     4,
     {70, 7, 3, 0},
     0.42,
     0.13,
     {0.070, 0.045, 0.030},
     {0.022, 0.070, 0.032}},
    {"stone pine",
     57220,
     15.0,
     0.38,
     0.62,
     0.42,
     0.60,
     -0.10,
     CROWN_UMBRELLA,
     4,
     {22, 9, 6, 0},
     0.36,
     0.14,
     {0.150, 0.075, 0.042},
     {0.045, 0.105, 0.030}},
    {"cypress",
     42800,
     17.0,
     0.28,
     0.05,
     0.105,
     1.60,
     -0.05,
     CROWN_COLUMN,
     3,
     {150, 8, 0, 0},
     0.34,
     0.18,
     {0.090, 0.065, 0.045},
     {0.020, 0.055, 0.022}},
    {"plane tree",
     60800,
     18.0,
     0.48,
     0.28,
     0.40,
     0.55,
     0.05,
     CROWN_ROUND,
     4,
     {24, 8, 6, 0},
     0.36,
     0.32,
     {0.260, 0.240, 0.180},
     {0.110, 0.190, 0.045}},
};

// A tree is walked twice: first to count twigs and wood, then to make it, with leaves on each twig.
typedef struct tree_walk {
    mesh_builder* builder;
    const tree_kind* kind;
    bool counting;
    double detail;  ///< share of the branches that grow: 1 is all
    uint64_t twigs; ///< visited so far
    uint64_t all_twigs, wood, leaves;
} tree_walk;

typedef struct branch {
    stp_vec3d start, direction;
    double length, radius;
    int level;
    random_stream random;
} branch;

const char* tree_name(uint32_t kind)
{
    return kinds[kind].name;
}

uint32_t tree_triangles(uint32_t kind)
{
    return kinds[kind].triangles;
}

static stp_vec3d across(stp_vec3d axis)
{
    stp_vec3d helper = axis.y * axis.y < 0.8 ? (stp_vec3d){0, 1, 0} : (stp_vec3d){1, 0, 0};
    return stp_normalized(stp_crossd(axis, helper));
}

static stp_vec3d along(stp_vec3d a, stp_vec3d b, double amount)
{
    return stp_addd(a, stp_scaled(b, amount));
}

// Perturbs a direction at random.
static stp_vec3d shake(random_stream* random, stp_vec3d direction, double amount)
{
    stp_vec3d by; // separate statements: the evaluation order in a list is unspecified
    by.x = random_between(random, -amount, amount);
    by.y = random_between(random, -amount, amount);
    by.z = random_between(random, -amount, amount);
    return stp_normalized(stp_addd(direction, by));
}

static uint32_t put_ring(mesh_builder* builder, stp_vec3d center, stp_vec3d axis, double radius,
                         int sides)
{
    stp_vec3d u = across(axis), v = stp_crossd(axis, u);
    uint32_t first = 0;
    for (int i = 0; i < sides; ++i) {
        double c = turn_cosine((double)i / sides), s = turn_sine((double)i / sides);
        stp_vec3d out = stp_addd(stp_scaled(u, c), stp_scaled(v, s));
        uint32_t index = mesh_builder_vertex(builder, stp_to_float(along(center, out, radius)),
                                             stp_to_float(out));
        first = i == 0 ? index : first;
    }
    return first;
}

static void join_rings(mesh_builder* builder, uint32_t below, uint32_t above, int sides)
{
    for (uint32_t i = 0; i < (uint32_t)sides; ++i) {
        uint32_t next = (i + 1) % (uint32_t)sides;
        mesh_builder_triangle(builder, below + i, below + next, above + next);
        mesh_builder_triangle(builder, below + i, above + next, above + i);
    }
}

// A diamond from its stalk. Its normal leans outwards, so that the crown is shaded as a whole.
static void put_leaf(tree_walk* walk, random_stream* random, stp_vec3d stalk, stp_vec3d twig)
{
    const tree_kind* kind = walk->kind;
    stp_vec3d direction = shake(random, twig, 0.9);
    stp_vec3d helper = shake(random, across(direction), 0.8);
    stp_vec3d side = stp_normalized(stp_crossd(direction, helper));
    double length = kind->leaf_length * random_between(random, 0.7, 1.3);
    double width = 0.5 * kind->leaf_width * random_between(random, 0.7, 1.3);
    stp_vec3d middle = along(stalk, direction, 0.45 * length);
    stp_vec3d face = stp_normalized(stp_crossd(direction, side));
    stp_vec3d outward = stp_normalized(
        (stp_vec3d){stalk.x, stalk.y - 0.55 * kind->height + 0.1 * kind->height, stalk.z});
    double turn = stp_dotd(face, outward) < 0.0 ? -1.0 : 1.0;
    stp_vec3 normal = stp_to_float(along(stp_scaled(face, turn), outward, 0.7));
    double shade = random_between(random, 0.65, 1.35), yellow = random_between(random, 0.85, 1.25);
    mesh_builder_color(walk->builder, kind->leaf[0] * shade * yellow, kind->leaf[1] * shade,
                       kind->leaf[2] * shade);
    stp_vec3d corners[4] = {stalk, along(middle, side, width * turn),
                            along(stalk, direction, length), along(middle, side, -width * turn)};
    uint32_t first = 0;
    for (int i = 0; i < 4; ++i) {
        uint32_t index = mesh_builder_vertex(walk->builder, stp_to_float(corners[i]), normal);
        first = i == 0 ? index : first;
    }
    mesh_builder_triangle(walk->builder, first, first + 1, first + 2);
    mesh_builder_triangle(walk->builder, first, first + 2, first + 3);
}

static void put_leaves(tree_walk* walk, branch* b, stp_vec3d end)
{
    uint64_t twig = walk->twigs++;
    if (walk->counting) {
        return;
    }
    uint64_t begin = walk->leaves * twig / walk->all_twigs;
    uint64_t stop = walk->leaves * (twig + 1) / walk->all_twigs;
    for (; begin < stop; ++begin) {
        double t = random_between(&b->random, 0.15, 1.05);
        stp_vec3d stalk = along(b->start, stp_subd(end, b->start), t);
        put_leaf(walk, &b->random, stalk, b->direction);
    }
}

static double crown_length(crown_shape crown, double t)
{
    switch (crown) {
    case CROWN_CONE:
        return 1.02 - t;
    case CROWN_COLUMN:
        return (t < 0.12 ? 0.5 + 4.0 * t : 1.0 - 0.95 * (t - 0.12) * (t - 0.12) / 0.7744);
    case CROWN_UMBRELLA:
        return 0.75 + 0.25 * t;
    default:
        return 0.35 + 2.6 * t * (1.0 - t) * (1.25 - 0.5 * t);
    }
}

// The child that leaves a branch at fraction `t` of its length.
static branch grow_child(const tree_walk* walk, const branch* parent, stp_vec3d at, double t,
                         uint32_t number)
{
    const tree_kind* kind = walk->kind;
    branch child = {.start = at, .level = parent->level + 1};
    child.random = random_fork(&parent->random, number);
    double turns = (double)number * 0.38196601125 + random_between(&child.random, -0.06, 0.06);
    stp_vec3d u = across(parent->direction), v = stp_crossd(parent->direction, u);
    stp_vec3d out = stp_addd(stp_scaled(u, turn_cosine(turns)), stp_scaled(v, turn_sine(turns)));
    if (child.level == 1) {
        double up = kind->rise + (kind->crown == CROWN_ROUND ? 0.9 * (t - 0.4) : 0.0);
        child.direction = stp_normalized(along(out, parent->direction, up));
        child.length = kind->height * kind->spread * crown_length(kind->crown, t) *
                       random_between(&child.random, 0.8, 1.15);
    } else {
        child.direction = stp_normalized(along(stp_scaled(out, 0.75), parent->direction, 0.8));
        child.length =
            parent->length * (0.62 - 0.32 * t) * random_between(&child.random, 0.75, 1.2);
    }
    double thin = child.level == 1 ? 0.34 : 0.5;
    child.radius = parent->radius * thin * (1.05 - 0.6 * t);
    return child;
}

static void grow(tree_walk* walk, branch* b)
{
    static const int segments[MOST_LEVELS] = {10, 4, 3, 1}, sides[MOST_LEVELS] = {10, 5, 3, 3};
    const tree_kind* kind = walk->kind;
    int count = segments[b->level], around = sides[b->level];
    double step = b->length / count;
    stp_vec3d points[11];
    points[0] = b->start;
    stp_vec3d direction = b->direction;
    for (int i = 1; i <= count; ++i) {
        double bend = b->level == 0 ? 0.035 : 0.12;
        direction.y -= b->level > 0 ? kind->droop / count : 0.0;
        direction = shake(&b->random, direction, bend);
        points[i] = along(points[i - 1], direction, step);
    }
    walk->wood += walk->counting ? (uint64_t)(2 * count * around) : 0;
    uint32_t below = 0;
    for (int i = 0; !walk->counting && i <= count; ++i) {
        stp_vec3d axis =
            stp_normalized(stp_subd(points[i < count ? i + 1 : i], points[i > 0 ? i - 1 : i]));
        double radius = b->radius * (1.0 - 0.85 * (double)i / count);
        radius *= b->level == 0 && i == 0 ? 1.6 : 1.0; // root flare
        double shade = 0.8 + 0.4 * random_unit(&b->random);
        mesh_builder_color(walk->builder, kind->bark[0] * shade, kind->bark[1] * shade,
                           kind->bark[2] * shade);
        uint32_t above = put_ring(walk->builder, points[i], axis, radius, around);
        if (i > 0) {
            join_rings(walk->builder, below, above, around);
        }
        below = above;
    }
    int children = (int)((double)kind->children[b->level] * walk->detail + 0.999);
    for (int i = 0; b->level + 1 < kind->levels && i < children; ++i) {
        double first = b->level == 0 ? kind->bare : 0.18;
        double t = ((double)i + 0.5) / children, at = (first + (1.0 - first) * t) * count;
        int segment = (int)at < count ? (int)at : count - 1;
        stp_vec3d from = points[segment];
        stp_vec3d start = along(from, stp_subd(points[segment + 1], from), at - segment);
        branch child = grow_child(walk, b, start, t, (uint32_t)i);
        grow(walk, &child);
    }
    if (b->level + 1 == kind->levels) {
        put_leaves(walk, b, points[count]);
    }
}

void tree_make(mesh_builder* builder, const void* parameters)
{
    const tree_recipe* recipe = parameters;
    assert(recipe->kind < TREE_KINDS && recipe->triangles % 2 == 0);
    const tree_kind* kind = &kinds[recipe->kind];
    if (builder->counting) {
        builder->index_count += 3 * (size_t)recipe->triangles;
        return;
    }
    tree_walk walk = {.builder = builder, .kind = kind, .detail = 1.0};
    branch trunk = {.direction = {0, 1, 0},
                    .length = kind->height * 0.92,
                    .radius = kind->trunk_radius,
                    .random = random_begin(recipe->seed * TREE_KINDS + recipe->kind)};
    for (;;) { // fewer branches for low triangle counts
        branch copy = trunk;
        walk.counting = true;
        walk.twigs = walk.wood = 0;
        grow(&walk, &copy);
        if (walk.wood <= recipe->triangles || walk.detail < 0.02) {
            break;
        }
        walk.detail *= 0.8;
    }
    walk.counting = false;
    walk.all_twigs = walk.twigs;
    walk.leaves = walk.wood < recipe->triangles ? (recipe->triangles - walk.wood) / 2 : 0;
    walk.twigs = 0;
    grow(&walk, &trunk);
}
