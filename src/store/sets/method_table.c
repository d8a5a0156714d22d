// SPDX-License-Identifier: MIT
// The methods of the file's sets, and the set of each node for each method (docs/format.md,
// Methods).
#include "store/file/tables.h"
#include "store/sets/sets_internal.h"

#include <assert.h>

enum { METHODS_MAX = 16 };

static const stp_store_method only_blue = {.name = "blue", .id = STP_METHOD_BLUE};

// Coarse ellipses are drawn in place of another method's splats, so they follow it.
static bool is_known(const stp_store_directory* d, uint32_t index, bool is_first)
{
    uint32_t id = d->methods[index].id;
    bool is_coarse = id == STP_METHOD_COARSE && !is_first && index + 1 == d->method_count;
    return is_coarse || (id >= STP_METHOD_BLUE && id <= STP_METHOD_STOCHASTIC);
}

uint32_t stp_store_offered_methods(const stp_store_directory* directory)
{
    uint32_t count = directory->method_count;
    bool is_coarse = count > 1 && directory->methods[count - 1].id == STP_METHOD_COARSE;
    return is_coarse ? count - 1 : count;
}

uint32_t stp_store_find_method(const stp_store_directory* directory, uint32_t id)
{
    for (uint32_t i = 0; i < directory->method_count; ++i) {
        if (directory->methods[i].id == id) {
            return i;
        }
    }
    return 0;
}

bool stp_store_lists_methods(const stp_store_directory* directory)
{
    return directory->method_count > 1 ||
           (directory->method_count == 1 && directory->methods[0].id != STP_METHOD_BLUE);
}

// What is wrong with a method whose sets must begin at `first_set`, or NULL.
static const char* find_fault(const stp_store_directory* d, uint32_t index, uint32_t first_set)
{
    assert(first_set <= d->set_count);
    const stp_store_method* method = &d->methods[index];
    for (uint32_t i = 0; i < index; ++i) {
        if (d->methods[i].id == method->id) {
            return "occurs twice";
        }
    }
    if (method->name == NULL || method->name[0] == '\0' || method->id == 0) {
        return "has no name or id";
    }
    if (method->first_set != first_set || method->set_count > d->set_count - first_set) {
        return "has sets that do not follow those of the previous method";
    }
    if ((method->columns & ~(uint32_t)STP_SPLATS_COLUMNS) != 0) {
        return "has columns that this version does not define";
    }
    if ((method->columns & STP_SPLATS_ERRORS) != 0 && (method->columns & STP_SPLATS_RANGES) == 0) {
        return "has errors but no ranges";
    }
    return NULL;
}

static stp_result check_table(const stp_store_validator* validator, const stp_store_directory* d)
{
    uint32_t end = 0;
    for (uint32_t i = 0; i < d->method_count; ++i) {
        const char* fault = find_fault(d, i, end);
        if (fault != NULL) {
            return stp_fail(validator->context, validator->failure, "%s: method %u %s",
                            validator->path, i, fault);
        }
        end += d->methods[i].set_count;
    }
    if (end != d->set_count) {
        return stp_fail(validator->context, validator->failure,
                        "%s: has %u sets, %u of them without a method", validator->path,
                        d->set_count, d->set_count - end);
    }
    return STP_OK;
}

// The first method's sets are the nodes' own.
static stp_result check_first(const stp_store_validator* validator, const stp_store_directory* d)
{
    for (uint32_t i = 0; i < d->node_count; ++i) {
        uint32_t set = d->nodes[i].set;
        if (set != STP_STORE_NONE && set >= d->methods[0].set_count) {
            return stp_fail(validator->context, validator->failure,
                            "%s: node %u: set %u is not of the first method", validator->path, i,
                            set);
        }
    }
    return STP_OK;
}

// Fails unless each set of the method belongs to exactly one node.
static stp_result check_nodes(const stp_store_validator* validator, const stp_store_directory* d,
                              uint32_t method)
{
    const stp_store_method* m = &d->methods[method];
    uint8_t* named = STP_NEW_ZEROED(validator->context, uint8_t, (size_t)m->set_count + 1);
    if (named == NULL) {
        return stp_fail_memory(validator->context);
    }
    uint32_t count = 0;
    bool good = true;
    for (uint32_t i = 0; i < d->node_count && good; ++i) {
        uint32_t set = m->sets[i];
        if (set == STP_STORE_NONE) {
            continue;
        }
        good = set >= m->first_set && set - m->first_set < m->set_count &&
               named[set - m->first_set] == 0;
        if (good) {
            named[set - m->first_set] = 1;
            count += 1;
        }
    }
    stp_free(validator->context, named);
    return good && count == m->set_count
               ? STP_OK
               : stp_fail(validator->context, validator->failure,
                          "%s: method %u: each of its sets must belong to exactly one node",
                          validator->path, method);
}

stp_result stp_store_validate_methods(const stp_store_validator* validator,
                                      const stp_store_content* content)
{
    const stp_store_directory* d = &content->directory;
    if (d->method_count == 0) {
        return STP_OK;
    }
    stp_result result = check_table(validator, d);
    result = result == STP_OK ? check_first(validator, d) : result;
    for (uint32_t m = 1; m < d->method_count && result == STP_OK; ++m) {
        result = check_nodes(validator, d, m);
    }
    for (uint32_t m = 0; m < d->method_count && result == STP_OK; ++m) {
        for (uint32_t i = 0; i < d->methods[m].set_count; ++i) {
            const stp_splats* set = &content->sets[d->methods[m].first_set + i];
            bool shapes = (set->columns & STP_SPLATS_SHAPES) != 0;
            bool ranges = (set->columns & STP_SPLATS_RANGES) != 0;
            bool errors = (set->columns & STP_SPLATS_ERRORS) != 0;
            bool there = set->count == 0 ||
                         ((set->shapes != NULL || !shapes) && (set->ranges != NULL || !ranges) &&
                          (set->errors != NULL || !errors));
            if (set->columns != d->methods[m].columns || !there) {
                return stp_fail(validator->context, validator->failure,
                                "%s: splat set %u: its columns differ from its method's",
                                validator->path, d->methods[m].first_set + i);
            }
        }
    }
    return result;
}

// The sets of all methods but the first, by node.
static stp_result gather_sets(stp_store* store)
{
    const stp_store_directory* d = &store->directory;
    const uint32_t* nodes = store->tables[STP_SECTION_METHOD_NODES];
    uint32_t first = store->methods[0].set_count, count = store->counts[STP_SECTION_METHOD_NODES];
    assert(first <= d->set_count);
    if (count != d->set_count - first) {
        return stp_fail(store->context, STP_ERROR_FORMAT, "%s: lists nodes for %u sets but has %u",
                        store->path, count, d->set_count - first);
    }
    size_t each = d->node_count;
    if (d->method_count <= 1) {
        return STP_OK;
    }
    store->method_sets =
        STP_NEW_ARRAY(store->context, uint32_t, (size_t)(d->method_count - 1) * each + 1);
    if (store->method_sets == NULL) {
        return stp_fail_memory(store->context);
    }
    for (uint32_t m = 1; m < d->method_count; ++m) {
        uint32_t* sets = store->method_sets + (m - 1) * each;
        store->methods[m].sets = sets;
        for (size_t i = 0; i < each; ++i) {
            sets[i] = STP_STORE_NONE;
        }
        for (uint32_t i = 0; i < store->methods[m].set_count; ++i) {
            assert(store->methods[m].first_set - first < count - i && "sets follow each other");
            uint32_t set = store->methods[m].first_set + i, node = nodes[set - first];
            if (node >= d->node_count || sets[node] != STP_STORE_NONE) {
                return stp_fail(store->context, STP_ERROR_FORMAT,
                                "%s: splat set %u: its node does not exist or has another set",
                                store->path, set);
            }
            sets[node] = set;
        }
    }
    return STP_OK;
}

static void spread_columns(stp_store* store)
{
    stp_store_set_record* sets = store->tables[STP_SECTION_SPLAT_SETS];
    for (uint32_t m = 0; m < store->directory.method_count; ++m) {
        const stp_store_method* method = &store->methods[m];
        for (uint32_t i = 0; i < method->set_count; ++i) {
            sets[method->first_set + i].splats.columns = method->columns;
        }
    }
}

// Drops methods that this version does not know; the first remaining one becomes the nodes' own.
static stp_result drop_unknown(stp_store* store)
{
    stp_store_directory* d = &store->directory;
    stp_store_node* nodes = store->tables[STP_SECTION_NODES];
    const char* unknown = NULL;
    uint32_t kept = 0;
    for (uint32_t m = 0; m < d->method_count; ++m) {
        if (!is_known(d, m, kept == 0)) {
            unknown = unknown == NULL ? store->methods[m].name : unknown;
            continue;
        }
        const uint32_t* sets = store->methods[m].sets;
        for (uint32_t i = 0; kept == 0 && sets != NULL && i < d->node_count; ++i) {
            nodes[i].set = sets[i];
        }
        store->methods[kept] = store->methods[m];
        store->methods[kept].sets = kept == 0 ? NULL : sets;
        kept += 1;
    }
    if (kept == 0 && d->method_count != 0) {
        return stp_fail(store->context, STP_ERROR_UNSUPPORTED,
                        "%s: has splats of only the method %s, which this version does not support",
                        store->path, unknown);
    }
    d->method_count = kept;
    return STP_OK;
}

stp_result stp_store_read_method_names(stp_store* store, stp_store_text* text)
{
    stp_store_directory* d = &store->directory;
    bool has_methods = store->known[STP_SECTION_METHODS] != NULL;
    stp_result result = stp_store_read_table(store, STP_SECTION_METHODS, text);
    if (result != STP_OK) {
        return result;
    }
    uint32_t count = has_methods ? store->counts[STP_SECTION_METHODS] : 1;
    const stp_store_method_record* records = store->tables[STP_SECTION_METHODS];
    if (count == 0 || count > METHODS_MAX) {
        return stp_fail(store->context, STP_ERROR_FORMAT, "%s: has %u methods, expected 1 to %d",
                        store->path, count, METHODS_MAX);
    }
    store->methods = STP_NEW_ARRAY(store->context, stp_store_method, count);
    if (store->methods == NULL) {
        return stp_fail_memory(store->context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        store->methods[i] = has_methods ? records[i].method : only_blue;
    }
    d->methods = store->methods;
    d->method_count = count;
    return STP_OK;
}

stp_result stp_store_read_methods(stp_store* store, stp_store_text* text)
{
    stp_store_directory* d = &store->directory;
    stp_result result = stp_store_read_method_names(store, text);
    result =
        result == STP_OK ? stp_store_read_table(store, STP_SECTION_METHOD_NODES, text) : result;
    if (result != STP_OK) {
        return result;
    }
    if (store->known[STP_SECTION_METHODS] == NULL) {
        store->methods[0].set_count = d->set_count;
    }
    stp_store_validator validator = stp_store_own_validator(store);
    result = check_table(&validator, d);
    result = result == STP_OK ? check_first(&validator, d) : result;
    result = result == STP_OK ? gather_sets(store) : result;
    if (result != STP_OK) {
        return result;
    }
    spread_columns(store);
    return drop_unknown(store);
}
