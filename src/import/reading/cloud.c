// SPDX-License-Identifier: MIT
#include "import/reading/cloud.h"

#include "scene/bulk.h"

#include <assert.h>
#include <string.h>

#define LONGEST_RUN ((size_t)1 << 20) ///< cells

void stp_cloud_set_axes(stp_import* import)
{
    stp_import_set_axes(import, import->desc.up != 0 ? import->desc.up : 'z', 0.0);
    import->wants_unit = true;
}

stp_result stp_cloud_create(stp_cloud* cloud, stp_import* import, uint64_t count,
                            const stp_point_columns_desc* desc)
{
    *cloud = (stp_cloud){.import = import};
    if (count >= STP_NONE) {
        return stp_fail(import->context, STP_ERROR_LIMIT,
                        "%s: has more than 2^32 points in one scan", import->path);
    }
    stp_point_columns_desc counted = *desc;
    counted.point_count = (uint32_t)count;
    return stp_point_columns_create(import, &counted, &cloud->set);
}

void stp_cloud_destroy(stp_cloud* cloud)
{
    if (cloud->import != NULL) {
        stp_point_columns_free(cloud->import, &cloud->set);
    }
    *cloud = (stp_cloud){0};
}

void stp_cloud_set_origin(stp_cloud* cloud, const double place[3])
{
    stp_import_choose_origin(place, cloud->origin);
}

// Moves runs of filled cells at once. Releases spilled pages.
static void drop_empty(stp_cloud* cloud)
{
    stp_bulk_array arrays[STP_POINT_ARRAYS];
    size_t count = cloud->set.point_count, kept = 0, at = 0;
    stp_points_get_arrays(&cloud->set, arrays);
    for (size_t released = 0; at < count;) {
        size_t begin = at;
        if (begin - released >= LONGEST_RUN) {
            stp_point_columns_release(cloud->import, &cloud->set);
            released = begin;
        }
        while (at < count && at - begin < LONGEST_RUN && !stp_cloud_is_empty(cloud, at)) {
            at += 1;
        }
        assert(kept <= begin && "points move to the front");
        for (int i = 0; i < STP_POINT_ARRAYS && kept != begin && at > begin; ++i) {
            unsigned char* bytes = arrays[i].bytes;
            size_t size = arrays[i].size / count;
            assert(arrays[i].size % count == 0 && "a whole number of points");
            if (bytes != NULL) {
                memmove(bytes + kept * size, bytes + begin * size, (at - begin) * size);
            }
        }
        kept += at - begin;
        while (at < count && stp_cloud_is_empty(cloud, at)) {
            at += 1;
        }
    }
    assert(kept <= count);
    cloud->set.point_count = (uint32_t)kept;
}

stp_result stp_cloud_finish(stp_cloud* cloud, const char* name, const stp_affine* pose)
{
    stp_scene* scene = cloud->import->scene;
    uint32_t object = cloud->import->root;
    stp_result result = STP_OK;
    drop_empty(cloud);
    if (name != NULL) {
        stp_object own = {.name = name, .parent = object, .transform = stp_affine_identity()};
        result = stp_scene_add_object(scene, &own, &object);
    }
    if (result != STP_OK) {
        return result;
    }
    assert(object < scene->object_count);
    stp_affine shift = stp_affine_identity();
    for (int i = 0; i < 3; ++i) {
        shift.m[i][3] = cloud->origin[i];
    }
    stp_affine* placed = &scene->objects[object].transform;
    *placed = stp_affine_multiply(*placed, stp_affine_multiply(*pose, shift));
    return cloud->set.point_count > 0 ? stp_point_columns_add(cloud->import, &cloud->set) : STP_OK;
}
