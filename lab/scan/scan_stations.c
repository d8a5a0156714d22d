// SPDX-License-Identifier: MIT
//
// Candidates stand on floors: positions spread over the plan, each on the lowest surface that faces
// up and has room above and around it. Each casts 960 rays and records which cells of the
// model's box they hit. Then the candidate that adds the most cells is chosen repeatedly; its
// weight is reduced if it is closer to chosen stations than evenly spread stations would be.
#include "base/math/rng.h"
#include "lab/scan/scan_sweep.h"
#include "lab/scenes/trigonometry.h"

#include <assert.h>

enum {
    CELLS = 32, ///< cells of the model's box along each axis
    WORDS = CELLS * CELLS * CELLS / 64,
    TURN = 48,                ///< test rays per horizontal turn
    RISE = 20,                ///< rows of test rays, from below to above
    SIDES = 16,               ///< horizontal directions that must be free
    RING = SCAN_MAX_STATIONS, ///< candidates around a model without floors
    FLOOR_CANDIDATES = 256,   ///< candidates over the plan, besides those per station
    CANDIDATES_PER_STATION = 8,
    MAX_FLOORS = 64, ///< maximum number of examined surfaces at one position of the plan
};

#define FACES_UP 0.7    ///< minimum vertical component of a floor's normal
#define SEES_ENOUGH 0.3 ///< minimum share of test rays that hit a surface

typedef struct candidate {
    stp_vec3d place;
    bool good;
    bool taken;
    double apart; ///< squared distance to the nearest station taken
    uint64_t cells[WORDS];
} candidate;

typedef struct chooser {
    const scan_target* target;
    const scan_placing* placing;
    stp_boxd bounds;
    double diagonal, height;
    double spacing; ///< distance between stations if they were spread evenly
    candidate* candidates;
    uint32_t floor_candidates; ///< number of candidates on floors; RING more follow
} chooser;

/// Random number in [0, 1).
static double random_of(const chooser* c, uint64_t index)
{
    return (double)(stp_rng_hash(c->placing->seed, index) >> 11) / 9007199254740992.0;
}

static double fraction_of(double value)
{
    return value - floor(value);
}

/// Finds the lowest floor with room above it; a roof above ground does not count. @return false if
/// there is none
static bool find_floor(const chooser* c, double x, double y, double* z)
{
    const stp_vec3d down = {0.0, 0.0, -1.0};
    double top = c->bounds.max.z + c->height, above = (double)INFINITY;
    double span = top - c->bounds.min.z + c->height, from = 0.0, lowest = 0.0;
    bool found = false;
    scan_surface s;
    for (int i = 0; i < MAX_FLOORS; ++i) {
        if (!scan_target_intersect(c->target, (stp_vec3d){x, y, top}, down, from, span, &s)) {
            break;
        }
        bool floor = s.normal.z > FACES_UP && !s.from_behind;
        lowest = floor ? s.place.z : lowest;
        if (floor && above - s.place.z > 1.25 * c->height) {
            *z = s.place.z;
            found = true;
        }
        above = s.place.z;
        from = s.distance + 1e-9 * c->diagonal;
    }
    return found && *z - lowest < c->height;
}

static bool has_room(const chooser* c, stp_vec3d place)
{
    scan_surface s;
    for (int i = 0; i < SIDES; ++i) {
        double turn = (double)i / SIDES;
        stp_vec3d side = {turn_cosine(turn), turn_sine(turn), 0.0};
        if (scan_target_intersect(c->target, place, side, 0.0, c->height / 4.0, &s)) {
            return false;
        }
    }
    return true;
}

static uint32_t cell_of(double value, double low, double high)
{
    double cell = high > low ? CELLS * (value - low) / (high - low) : 0.0;
    return cell > 0.0 ? cell < (double)(CELLS - 1) ? (uint32_t)cell : CELLS - 1 : 0;
}

/// Casts the test rays and marks the cells that they hit. @return the share of rays that hit a
/// surface
static double scan_around(const chooser* c, candidate* at)
{
    uint32_t met = 0;
    for (uint32_t i = 0; i < TURN * RISE; ++i) {
        double turn = (double)(i % TURN) / TURN;
        double z = -0.85 + 1.8 * ((double)(i / TURN) + 0.5) / RISE, level = sqrt(1.0 - z * z);
        stp_vec3d direction = {level * turn_cosine(turn), level * turn_sine(turn), z};
        scan_surface s;
        if (!scan_target_intersect(c->target, at->place, direction, 0.0, c->placing->range, &s)) {
            continue;
        }
        const stp_boxd* b = &c->bounds;
        uint32_t x = cell_of(s.place.x, b->min.x, b->max.x);
        uint32_t y = cell_of(s.place.y, b->min.y, b->max.y);
        uint32_t bit = (cell_of(s.place.z, b->min.z, b->max.z) * CELLS + y) * CELLS + x;
        at->cells[bit / 64] |= UINT64_C(1) << bit % 64;
        met += 1;
    }
    return (double)met / (TURN * RISE);
}

static void place_on_floors(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    chooser* c = user;
    const stp_boxd* b = &c->bounds;
    for (size_t i = begin; i < end; ++i) {
        // evenly spread positions (Roberts, The Unreasonable Effectiveness of Quasirandom
        // Sequences, 2018)
        candidate* at = &c->candidates[i];
        double u = fraction_of(random_of(c, 0) + 0.7548776662466927 * (double)(i + 1));
        double v = fraction_of(random_of(c, 1) + 0.5698402909980532 * (double)(i + 1));
        double x = b->min.x + u * (b->max.x - b->min.x), y = b->min.y + v * (b->max.y - b->min.y);
        double z;
        if (find_floor(c, x, y, &z)) {
            at->place = (stp_vec3d){x, y, z + c->height};
            at->good = has_room(c, at->place) && scan_around(c, at) >= SEES_ENOUGH;
        }
    }
}

// Positions around the model, at a distance that shows all of it, at two heights.
static void place_on_ring(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    chooser* c = user;
    const stp_boxd* b = &c->bounds;
    stp_vec3d center = stp_scaled(stp_addd(b->min, b->max), 0.5);
    for (size_t i = begin; i < end; ++i) {
        candidate* at = &c->candidates[c->floor_candidates + i];
        double turn = random_of(c, 2) + (double)i / RING;
        double z = i % 2 == 0 ? b->min.z + c->height : center.z + 0.3 * c->diagonal;
        at->place = (stp_vec3d){center.x + c->diagonal * turn_cosine(turn),
                                center.y + c->diagonal * turn_sine(turn), z};
        at->good = true;
        (void)scan_around(c, at);
    }
}

static uint32_t count_new(const candidate* at, const uint64_t* seen)
{
    uint32_t count = 0;
    for (size_t i = 0; i < WORDS; ++i) {
        count += (uint32_t)__builtin_popcountll(at->cells[i] & ~seen[i]);
    }
    return count;
}

/// The best candidate not yet chosen; there are always enough.
static candidate* find_best(const chooser* c, uint32_t count, const uint64_t* seen)
{
    candidate* best = NULL;
    double maximum = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        candidate* at = &c->candidates[i];
        if (!at->good || at->taken) {
            continue;
        }
        double near = fmin(1.0, sqrt(at->apart) / c->spacing);
        double score = (double)count_new(at, seen) * near;
        if (best == NULL || score > maximum || (score == maximum && at->apart > best->apart)) {
            best = at;
            maximum = score;
        }
    }
    return best;
}

static void take(const chooser* c, uint32_t count, candidate* best, uint64_t* seen)
{
    best->taken = true;
    for (size_t i = 0; i < WORDS; ++i) {
        seen[i] |= best->cells[i];
    }
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3d to = stp_subd(c->candidates[i].place, best->place);
        c->candidates[i].apart = fmin(c->candidates[i].apart, stp_dotd(to, to));
    }
}

/// Number of cells that candidates [begin, end) see together.
static uint32_t count_seen(const chooser* c, uint32_t begin, uint32_t end)
{
    uint32_t count = 0;
    for (size_t word = 0; word < WORDS; ++word) {
        uint64_t bits = 0;
        for (uint32_t i = begin; i < end; ++i) {
            bits |= c->candidates[i].good ? c->candidates[i].cells[word] : 0;
        }
        count += (uint32_t)__builtin_popcountll(bits);
    }
    return count;
}

// Drops the floors if positions around the model see more, as for a free-standing object; else
// drops the positions around it, if there are enough floors.
static void prefer_ring(const chooser* c)
{
    uint32_t good = 0, all = c->floor_candidates + RING;
    for (uint32_t i = 0; i < c->floor_candidates; ++i) {
        good += c->candidates[i].good ? 1 : 0;
    }
    bool around = count_seen(c, c->floor_candidates, all) > count_seen(c, 0, c->floor_candidates);
    for (uint32_t i = 0; i < all; ++i) {
        bool floor = i < c->floor_candidates;
        bool left = around ? floor : !floor && good >= c->placing->count;
        c->candidates[i].good = c->candidates[i].good && !left;
    }
}

static void choose(const chooser* c, uint32_t count, uint64_t* seen, stp_vec3d* stations)
{
    for (uint32_t i = 0; i < count; ++i) {
        c->candidates[i].apart = (double)INFINITY;
    }
    for (uint32_t k = 0; k < c->placing->count; ++k) {
        candidate* best = find_best(c, count, seen);
        assert(best != NULL && "RING alone has enough candidates");
        take(c, count, best, seen);
        stations[k] = best->place;
    }
}

stp_result scan_place_stations(const scan_target* target, const scan_placing* placing,
                               stp_vec3d* stations)
{
    stp_context* context = target->context;
    assert(placing->count >= 1 && placing->count <= SCAN_MAX_STATIONS);
    chooser c = {.target = target,
                 .placing = placing,
                 .bounds = stp_caster_bounds(target->caster),
                 .floor_candidates = FLOOR_CANDIDATES + CANDIDATES_PER_STATION * placing->count};
    stp_vec3d size = stp_subd(c.bounds.max, c.bounds.min);
    c.diagonal = sqrt(stp_dotd(size, size));
    c.spacing = sqrt(fmax(size.x * size.y, 1e-12 * c.diagonal * c.diagonal) / placing->count);
    c.height = placing->height > 0.0 ? placing->height : fmin(1.8, 0.1 * c.diagonal);
    uint64_t* seen = STP_NEW_ZEROED(context, uint64_t, WORDS);
    c.candidates = STP_NEW_ZEROED(context, candidate, (size_t)c.floor_candidates + RING);
    stp_result result = seen != NULL && c.candidates != NULL ? STP_OK : stp_fail_memory(context);
    if (result == STP_OK) {
        stp_parallel_for(context, c.floor_candidates, 4, place_on_floors, &c);
        stp_parallel_for(context, RING, 1, place_on_ring, &c);
        prefer_ring(&c);
        choose(&c, c.floor_candidates + RING, seen, stations);
    }
    stp_free(context, c.candidates);
    stp_free(context, seen);
    return result;
}
