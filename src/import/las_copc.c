// SPDX-License-Identifier: MIT
//
// COPC: the chunks of a LAZ file are the nodes of an octree, and pages of a hierarchy say which lies where. All points
// are read by the table of chunks, so a damaged hierarchy costs nothing but a warning.
//
// Facts of the format: COPC Specification 1.0.
#include "base/bytes.h"
#include "import/las.h"

#include <string.h>

enum {
    INFO_ID = 1,
    INFO_SIZE = 160,
    ENTRY_SIZE = 32,
    ROOT_OFFSET = 40,
    ROOT_SIZE = 48,
    MOST_DEPTH = 64
};

typedef struct hierarchy {
    const stp_las* las;
    uint64_t points;  ///< of all entries so far
    uint64_t entries; ///< seen so far; a file of so many bytes has no more than `most`
    uint64_t most;
    const char* fault;
} hierarchy;

static void read_page(hierarchy* h, uint64_t offset, uint64_t size, int depth)
{
    const stp_mapped_file* file = &h->las->import->file;
    if (depth > MOST_DEPTH || offset > file->size || size > file->size - offset ||
        size % ENTRY_SIZE != 0) {
        h->fault = "a page of it lies outside the file";
        return;
    }
    const unsigned char* at = file->bytes + offset;
    for (uint64_t i = 0; i < size / ENTRY_SIZE && h->fault == NULL; ++i, at += ENTRY_SIZE) {
        uint64_t place = stp_read_u64(at + 16);
        int32_t bytes = (int32_t)stp_read_u32(at + 24), count = (int32_t)stp_read_u32(at + 28);
        h->entries += 1;
        if (h->entries > h->most) {
            h->fault = "it has more entries than there is room for";
        } else if (bytes < 0 || count < -1 || place > file->size ||
                   (uint64_t)bytes > file->size - place) {
            h->fault = "an entry of it lies outside the file";
        } else if (count < 0) {
            read_page(h, place, (uint64_t)bytes, depth + 1);
        } else {
            h->points += (uint64_t)count;
        }
    }
}

void stp_las_check_copc(const stp_las* las)
{
    stp_las_record info;
    if (!stp_las_find_record(las, "copc", INFO_ID, &info) || info.size < INFO_SIZE) {
        return;
    }
    hierarchy h = {.las = las, .most = las->import->file.size / ENTRY_SIZE};
    read_page(&h, stp_read_u64(info.bytes + ROOT_OFFSET), stp_read_u64(info.bytes + ROOT_SIZE), 0);
    if (h.fault == NULL && h.points != las->point_count) {
        h.fault = "its points are not as many as the header promises";
    }
    if (h.fault != NULL) {
        stp_warn(las->context, "%s: its COPC hierarchy is damaged (%s): read as LAZ",
                 las->import->path, h.fault);
    }
}
