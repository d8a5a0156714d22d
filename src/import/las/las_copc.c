// SPDX-License-Identifier: MIT
//
// COPC: the chunks of a LAZ file are the nodes of an octree, and hierarchy pages give their
// offsets. Points are read through the chunk table, so a damaged hierarchy only causes a warning.
#include "base/io/bytes.h"
#include "import/las/las.h"

#include <assert.h>
#include <string.h>

enum {
    INFO_ID = 1,
    INFO_SIZE = 160,
    ENTRY_SIZE = 32,
    ROOT_OFFSET = 40,
    ROOT_SIZE = 48,
    MAX_DEPTH = 64
};

enum { LEVELS = 64 };

typedef struct hierarchy {
    const stp_las* las;
    uint8_t* levels_of;            ///< level of each chunk; NULL: not needed
    uint64_t of_level[LEVELS + 1]; ///< points of each level; deeper ones in the last
    uint64_t points;               ///< points of all entries so far
    uint64_t entries;              ///< so far; a valid file has at most `maximum`
    uint64_t maximum;
    uint64_t nodes;  ///< nodes with points
    uint32_t levels; ///< levels down to the deepest node with points
    const char* fault;
} hierarchy;

#ifndef NDEBUG
static bool are_chunks_in_order(const stp_las* las)
{
    for (size_t i = 1; i < las->chunk_count; ++i) {
        if (las->chunks[i - 1].offset > las->chunks[i].offset) {
            return false;
        }
    }
    return true;
}
#endif

// The chunk at an offset of the file; chunks are in file order.
static stp_las_chunk* chunk_at(const stp_las* las, uint64_t place)
{
    size_t low = 0, high = las->chunk_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (las->chunks[middle].offset < place) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    bool found = low < las->chunk_count && las->chunks[low].offset == place;
    return found ? &las->chunks[low] : NULL;
}

static void add_node(hierarchy* h, uint32_t level, uint64_t place, uint64_t count)
{
    stp_las_chunk* chunk = h->levels_of != NULL ? chunk_at(h->las, place) : NULL;
    level = level < LEVELS ? level : LEVELS;
    assert(chunk == NULL || chunk->offset == place);
    h->points += count;
    h->of_level[level] += count;
    h->nodes += count > 0;
    h->levels = count > 0 && level >= h->levels ? level + 1 : h->levels;
    if (chunk != NULL) {
        h->levels_of[chunk - h->las->chunks] = (uint8_t)level;
    }
}

static void read_page(hierarchy* h, uint64_t offset, uint64_t size, int depth)
{
    const stp_mapped_file* file = &h->las->import->file;
    if (depth > MAX_DEPTH || offset > file->size || size > file->size - offset ||
        size % ENTRY_SIZE != 0) {
        h->fault = "a page of it lies outside the file";
        return;
    }
    const unsigned char* at = file->bytes + offset;
    for (uint64_t i = 0; i < size / ENTRY_SIZE && h->fault == NULL; ++i, at += ENTRY_SIZE) {
        uint64_t place = stp_read_u64(at + 16);
        int32_t bytes = (int32_t)stp_read_u32(at + 24), count = (int32_t)stp_read_u32(at + 28);
        h->entries += 1;
        if (h->entries > h->maximum) {
            h->fault = "it has more entries than the file can hold";
        } else if (bytes < 0 || count < -1 || place > file->size ||
                   (uint64_t)bytes > file->size - place) {
            h->fault = "an entry of it lies outside the file";
        } else if (count < 0) {
            read_page(h, place, (uint64_t)bytes, depth + 1);
        } else {
            add_node(h, stp_read_u32(at), place, (uint64_t)count);
        }
    }
}

// @return whether the file declares itself as COPC
static bool read_hierarchy(const stp_las* las, uint8_t* levels_of, hierarchy* h)
{
    stp_las_record info;
    *h = (hierarchy){
        .las = las, .levels_of = levels_of, .maximum = las->import->file.size / ENTRY_SIZE};
    if (!stp_las_find_record(las, "copc", INFO_ID, &info) || info.size < INFO_SIZE) {
        return false;
    }
    read_page(h, stp_read_u64(info.bytes + ROOT_OFFSET), stp_read_u64(info.bytes + ROOT_SIZE), 0);
    if (h->fault == NULL && h->points != las->point_count) {
        h->fault = "its number of points differs from the header's";
    }
    return true;
}

void stp_las_check_copc(const stp_las* las)
{
    hierarchy h;
    if (read_hierarchy(las, NULL, &h) && h.fault != NULL) {
        stp_warn(las->context, "%s: its COPC hierarchy is damaged (%s): read as LAZ",
                 las->import->path, h.fault);
    }
}

void stp_las_describe_copc(const stp_las* las, stp_scan_info* info)
{
    hierarchy h;
    info->copc = read_hierarchy(las, NULL, &h);
    info->copc_levels = h.levels;
    info->copc_nodes = h.nodes;
}

bool stp_las_sample_copc(stp_las* las, uint64_t maximum)
{
    hierarchy h;
    uint8_t* levels = stp_alloc(las->context, las->chunk_count);
    if (levels == NULL) {
        return false; // chunks are sampled without
    }
    assert(are_chunks_in_order(las) && "they are searched by offset");
    memset(levels, LEVELS, las->chunk_count);
    bool good = read_hierarchy(las, levels, &h) && h.fault == NULL;
    uint64_t points = 0;
    uint32_t end = 0; // levels [0, end) are read, always at least the first
    while (good && end < LEVELS && (end == 0 || points + h.of_level[end] <= maximum)) {
        points += h.of_level[end++];
    }
    assert(end <= LEVELS && "chunks outside the hierarchy have level LEVELS");
    for (size_t i = 0; i < las->chunk_count && good; ++i) {
        las->chunks[i].read = levels[i] < end ? las->chunks[i].count : 0;
    }
    stp_free(las->context, levels);
    return good && points > 0;
}
