// SPDX-License-Identifier: MIT
#include "base/core/jobs.h"
#include "base/math/rng.h"
#include "lab/decimate/subsample_cover.h"

#include <assert.h>
#include <string.h>

enum {
    GROUP_MIN = 3, ///< minimum number of sets removed together
    GROUP_MAX = 10,
    BATCH_MAX = 64,   ///< proposals made against the same cover
    BATCH_SHARE = 48, ///< a batch has at most one proposal per this many sets
    IDLE_PASSES = 3,  ///< passes without a gain before the end
    NOISE = 256,      ///< maximum change of a weight, of 1024
};

/// Sets that may leave the cover, and their replacements.
typedef struct proposal {
    uint32_t removed_count, added_count;
    uint32_t removed[GROUP_MAX], added[GROUP_MAX];
} proposal;

/// Memory of one worker. `gains` and `missing` are zero between proposals.
typedef struct relax_scratch {
    uint64_t* gains;   ///< per set: weight of the points that it would cover
    uint32_t* missing; ///< per point: number of its removed sets
    uint32_t* touched; ///< sets with uncovered points
    uint32_t* open;    ///< uncovered points
} relax_scratch;

typedef struct relaxation {
    const stp_cover_problem* problem;
    const stp_cover* cover;
    bool tighten;          ///< the count stays, the area falls
    const uint32_t* seeds; ///< sets of this batch
    uint64_t seed;         ///< seed of the random numbers of this batch
    proposal* proposals;
    relax_scratch* scratch;
} relaxation;

/// Lists a set and chosen ones that share points with it, in point order from a random start.
static uint32_t pick_group(const stp_cover_problem* p, const stp_cover* cover, uint32_t set,
                           uint64_t seed, uint32_t group[GROUP_MAX])
{
    uint32_t wanted = GROUP_MIN + stp_rng_below(seed, 0, GROUP_MAX - GROUP_MIN + 1);
    size_t begin = p->starts[set], size = p->starts[set + 1] - begin;
    assert(cover->places[set] != UINT32_MAX && size > 0 && wanted <= GROUP_MAX);
    size_t from = stp_rng_below(seed, 1, (uint32_t)size);
    uint32_t count = 0;
    group[count++] = set;
    for (size_t i = 0; i < size && count < wanted; ++i) {
        uint32_t point = p->members[begin + (from + i) % size];
        for (size_t s = p->set_starts[point];
             cover->depths[point] > 1 && s < p->set_starts[point + 1] && count < wanted; ++s) {
            uint32_t other = p->sets[s];
            bool known = cover->places[other] == UINT32_MAX;
            for (uint32_t g = 0; !known && g < count; ++g) {
                known = group[g] == other;
            }
            if (!known) {
                group[count++] = other;
            }
        }
    }
    return count;
}

/// Removes the group. @return number of points that are then uncovered, listed in `open`
static uint32_t open_points(const stp_cover_problem* p, const stp_cover* cover, relax_scratch* s,
                            const proposal* out)
{
    uint32_t count = 0;
    for (uint32_t g = 0; g < out->removed_count; ++g) {
        for (size_t i = p->starts[out->removed[g]]; i < p->starts[out->removed[g] + 1]; ++i) {
            uint32_t point = p->members[i];
            assert(s->missing[point] < cover->depths[point]);
            if (++s->missing[point] == cover->depths[point]) {
                s->open[count++] = point;
            }
        }
    }
    return count;
}

/// Lists the sets with uncovered points, and adds up the weights of these in `gains`.
/// @return number of sets
static uint32_t touch_sets(const stp_cover_problem* p, relax_scratch* s, uint32_t open_count)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < open_count; ++i) {
        uint32_t point = s->open[i];
        for (size_t k = p->set_starts[point]; k < p->set_starts[point + 1]; ++k) {
            uint32_t set = p->sets[k];
            if (s->gains[set] == 0) {
                s->touched[count++] = set;
            }
            s->gains[set] += p->weights[point];
        }
    }
    return count;
}

/// Finds the touched set that covers most, with random changes of all weights.
static uint32_t find_best(const relax_scratch* s, uint32_t touched_count, uint64_t seed)
{
    uint32_t best = UINT32_MAX;
    uint64_t maximum = 0;
    for (uint32_t i = 0; i < touched_count; ++i) {
        uint32_t set = s->touched[i];
        uint64_t gain = s->gains[set] * (1024 + stp_rng_below(seed, set, NOISE));
        if (gain > maximum || (gain == maximum && gain > 0 && set < best)) {
            maximum = gain;
            best = set;
        }
    }
    return best;
}

/// Covers the uncovered points again. @return false: needs more sets than were removed
static bool cover_open(const stp_cover_problem* p, const stp_cover* cover, relax_scratch* s,
                       uint32_t touched_count, uint64_t seed, proposal* out)
{
    for (;;) {
        uint32_t set = find_best(s, touched_count, seed);
        if (set == UINT32_MAX) {
            return true;
        }
        if (out->added_count == out->removed_count) {
            return false;
        }
        out->added[out->added_count++] = set;
        for (size_t i = p->starts[set]; i < p->starts[set + 1]; ++i) {
            uint32_t point = p->members[i];
            if (s->missing[point] == 0 || s->missing[point] != cover->depths[point]) {
                continue;
            }
            s->missing[point]--; // covered
            for (size_t k = p->set_starts[point]; k < p->set_starts[point + 1]; ++k) {
                assert(s->gains[p->sets[k]] >= p->weights[point]);
                s->gains[p->sets[k]] -= p->weights[point];
            }
        }
    }
}

/// Drops sets that are on both sides.
static void cancel(proposal* out)
{
    for (uint32_t r = 0; r < out->removed_count;) {
        uint32_t a = 0;
        while (a < out->added_count && out->added[a] != out->removed[r]) {
            a++;
        }
        if (a < out->added_count) {
            out->added[a] = out->added[--out->added_count];
            out->removed[r] = out->removed[--out->removed_count];
        } else {
            r++;
        }
    }
}

static double sum_areas(const stp_cover_problem* p, const uint32_t* sets, uint32_t count)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        sum += (double)p->areas[sets[i]];
    }
    return sum;
}

static void propose(const relaxation* r, relax_scratch* s, uint32_t set, uint64_t seed,
                    proposal* out)
{
    const stp_cover_problem* p = r->problem;
    out->added_count = 0;
    out->removed_count = pick_group(p, r->cover, set, seed, out->removed);
    uint32_t open_count = open_points(p, r->cover, s, out);
    uint32_t touched_count = touch_sets(p, s, open_count);
    bool covered = cover_open(p, r->cover, s, touched_count, stp_rng_hash(seed, 2), out);
    for (uint32_t i = 0; i < touched_count; ++i) {
        s->gains[s->touched[i]] = 0;
    }
    for (uint32_t g = 0; g < out->removed_count; ++g) {
        for (size_t i = p->starts[out->removed[g]]; i < p->starts[out->removed[g] + 1]; ++i) {
            s->missing[p->members[i]] = 0;
        }
    }
    cancel(out);
    bool good = covered;
    if (r->tighten) {
        good = covered && out->added_count == out->removed_count &&
               sum_areas(p, out->added, out->added_count) <
                   sum_areas(p, out->removed, out->removed_count);
    }
    if (!good) {
        out->removed_count = out->added_count = 0;
    }
}

static void propose_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const relaxation* r = user;
    for (size_t i = begin; i < end; ++i) {
        propose(r, &r->scratch[worker], r->seeds[i], stp_rng_hash(r->seed, i), &r->proposals[i]);
    }
}

/// Applies a proposal, unless an earlier change would leave points uncovered. @return whether it
/// was applied
static bool apply(const stp_cover_problem* p, stp_cover* cover, const proposal* change)
{
    assert(change->added_count <= change->removed_count && "the cover never grows");
    bool valid = change->removed_count > 0;
    for (uint32_t i = 0; valid && i < change->removed_count; ++i) {
        valid = cover->places[change->removed[i]] != UINT32_MAX;
    }
    for (uint32_t i = 0; valid && i < change->added_count; ++i) {
        valid = cover->places[change->added[i]] == UINT32_MAX;
    }
    if (!valid) {
        return false;
    }
    for (uint32_t i = 0; i < change->added_count; ++i) {
        stp_cover_add(p, cover, change->added[i]);
    }
    uint32_t out = 0;
    while (out < change->removed_count && stp_cover_is_redundant(p, cover, change->removed[out])) {
        stp_cover_remove(p, cover, change->removed[out++]);
    }
    if (out == change->removed_count) {
        return true;
    }
    while (out > 0) {
        stp_cover_add(p, cover, change->removed[--out]);
    }
    for (uint32_t i = 0; i < change->added_count; ++i) {
        stp_cover_remove(p, cover, change->added[i]);
    }
    return false;
}

/// Removes redundant sets, the last ones first.
static void drop_redundant(const stp_cover_problem* p, stp_cover* cover, uint32_t enough)
{
    for (uint32_t i = cover->count; i-- > 0 && cover->count > enough;) {
        if (stp_cover_is_redundant(p, cover, cover->chosen[i])) {
            stp_cover_remove(p, cover, cover->chosen[i]);
        }
    }
}

static void shuffle(uint32_t* sets, uint32_t count, uint64_t seed)
{
    for (uint32_t i = count; i > 1; --i) {
        uint32_t other = stp_rng_below(seed, i, i), set = sets[i - 1];
        sets[i - 1] = sets[other];
        sets[other] = set;
    }
}

/// Makes a proposal around each set of the cover, batch by batch. @return number of accepted
/// proposals
static uint32_t run_pass(const stp_team* team, relaxation* r, stp_cover* cover, uint32_t enough,
                         uint32_t* seeds, uint64_t seed)
{
    uint32_t count = cover->count, taken = 0;
    uint32_t batch = count / BATCH_SHARE < BATCH_MAX ? count / BATCH_SHARE + 1 : BATCH_MAX;
    assert(batch > 0 && batch <= BATCH_MAX);
    memcpy(seeds, cover->chosen, count * sizeof(*seeds));
    shuffle(seeds, count, seed);
    for (uint32_t at = 0; at < count && (r->tighten || cover->count > enough);) {
        uint32_t size = 0; // the next seeds that are still chosen
        while (at + size < count && size < batch) {
            if (cover->places[seeds[at + size]] != UINT32_MAX) {
                size++;
            } else {
                seeds[at + size] = seeds[at];
                at++;
            }
        }
        r->seeds = seeds + at;
        r->seed = stp_rng_hash(seed, (uint64_t)at << 32);
        stp_team_run(team, size, 1, propose_some, r);
        for (uint32_t i = 0; i < size && (r->tighten || cover->count > enough); ++i) {
            taken += apply(r->problem, cover, &r->proposals[i]) ? 1 : 0;
        }
        at += size;
    }
    if (!r->tighten) {
        drop_redundant(r->problem, cover, enough);
    }
    return taken;
}

static bool make_scratch(stp_context* context, const stp_cover_problem* p, const stp_team* team,
                         relaxation* r)
{
    r->scratch = STP_NEW_ZEROED(context, relax_scratch, team->threads);
    r->proposals = STP_NEW_ARRAY(context, proposal, BATCH_MAX);
    bool made = r->scratch != NULL && r->proposals != NULL;
    for (uint32_t w = 0; made && w < team->threads; ++w) {
        relax_scratch* s = &r->scratch[w];
        s->gains = STP_NEW_ZEROED(context, uint64_t, (size_t)p->set_count + 1);
        s->missing = STP_NEW_ZEROED(context, uint32_t, (size_t)p->point_count + 1);
        s->touched = STP_NEW_ARRAY(context, uint32_t, (size_t)p->set_count + 1);
        s->open = STP_NEW_ARRAY(context, uint32_t, (size_t)p->point_count + 1);
        made = s->gains != NULL && s->missing != NULL && s->touched != NULL && s->open != NULL;
    }
    return made;
}

static void free_scratch(stp_context* context, const stp_team* team, relaxation* r)
{
    for (uint32_t w = 0; r->scratch != NULL && w < team->threads; ++w) {
        stp_free(context, r->scratch[w].gains);
        stp_free(context, r->scratch[w].missing);
        stp_free(context, r->scratch[w].touched);
        stp_free(context, r->scratch[w].open);
    }
    stp_free(context, r->scratch);
    stp_free(context, r->proposals);
}

/// Runs passes until the count reaches `enough`, or stops falling for a while.
static stp_result run_passes(stp_context* context, relaxation* r, uint32_t enough, uint32_t passes,
                             stp_cover* cover)
{
    stp_team team = stp_team_create_useful(context);
    uint32_t* seeds = STP_NEW_ARRAY(context, uint32_t, (size_t)cover->count + 1);
    bool made = make_scratch(context, r->problem, &team, r) && seeds != NULL;
    uint32_t idle = 0;
    r->cover = cover;
    for (uint32_t pass = 0; made && pass < passes && idle < IDLE_PASSES; ++pass) {
        uint32_t before = cover->count;
        uint32_t taken = run_pass(&team, r, cover, enough, seeds, stp_rng_hash(r->tighten, pass));
        bool ended = taken == 0 || (!r->tighten && cover->count <= enough);
        idle = r->tighten || cover->count < before ? 0 : idle + 1;
        idle = ended ? IDLE_PASSES : idle;
    }
    free_scratch(context, &team, r);
    stp_free(context, seeds);
    return made ? STP_OK : stp_fail_memory(context);
}

stp_result stp_cover_relax(stp_context* context, const stp_cover_problem* problem, uint32_t enough,
                           uint32_t passes, stp_cover* cover)
{
    relaxation r = {.problem = problem};
    drop_redundant(problem, cover, enough);
    return cover->count > enough ? run_passes(context, &r, enough, passes, cover) : STP_OK;
}

stp_result stp_cover_tighten(stp_context* context, const stp_cover_problem* problem,
                             uint32_t passes, stp_cover* cover)
{
    relaxation r = {.problem = problem, .tighten = true};
    return run_passes(context, &r, 0, passes, cover);
}
