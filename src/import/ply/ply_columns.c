// SPDX-License-Identifier: MIT
// Storage for the vertices of a PLY file while they are read. Points of scans are many: they go
// directly to the scene's spill file if memory could not hold them twice.
#include "import/ply/ply.h"
#include "import/reading/point_columns.h"

#include <assert.h>

bool stp_ply_has_faces(const stp_ply* ply)
{
    for (size_t i = 0; i < ply->element_count; ++i) {
        const stp_ply_element* element = &ply->elements[i];
        if (element->count > 0 && stp_ply_is_one_of(element->name, "face tristrips")) {
            return true;
        }
    }
    return false;
}

stp_result stp_ply_alloc_columns(const stp_ply* ply, stp_ply_room* room,
                                 stp_bulk_array columns[STP_PLY_COLUMNS])
{
    const stp_scene* scene = ply->import->scene;
    uint64_t size = 0;
    bool good = true;
    for (int i = 0; i < STP_PLY_COLUMNS; ++i) {
        size += columns[i].size;
    }
    *room = (stp_ply_room){0};
    room->spilled = stp_points_go_to_spill(scene, size) && !stp_ply_has_faces(ply);
    if (room->spilled) {
        assert(scene->spill != NULL && "it was chosen by its size");
        stp_result result = stp_spill_create_sibling(scene->spill, &room->scratch);
        result = result == STP_OK ? stp_bulk_alloc_spilled(scene->spill, columns, 2) : result;
        return result == STP_OK ? stp_bulk_alloc_spilled(room->scratch, columns + 2, 2) : result;
    }
    for (int i = 0; i < STP_PLY_COLUMNS; ++i) {
        bool wanted = i == 0 || columns[i].size > 0;
        columns[i].bytes = wanted ? stp_alloc(ply->context, columns[i].size) : NULL;
        good = good && (!wanted || columns[i].bytes != NULL);
    }
    return good ? STP_OK : stp_fail_memory(ply->context);
}

void stp_ply_free_column(const stp_ply* ply, const stp_ply_room* room, void* column)
{
    if (!room->spilled) {
        stp_free(ply->context, column);
    }
}

void stp_ply_release_columns(const stp_ply* ply, const stp_ply_room* room)
{
    if (room->spilled) {
        stp_point_columns_release(ply->import, &(stp_point_set){.spilled = true});
        assert(room->scratch != NULL && "spilled columns have a second file");
        stp_spill_release_pages(room->scratch);
    }
}
