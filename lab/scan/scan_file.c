// SPDX-License-Identifier: MIT
#include "lab/scan/scan_file.h"

#include <assert.h>
#include <string.h>
#include <strings.h>

const scan_format* scan_format_of(const char* path)
{
    static const scan_format* const all[] = {&scan_format_las, &scan_format_ptx, &scan_format_ply,
                                             &scan_format_e57};
    size_t length = strlen(path);
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); ++i) {
        size_t ending = strlen(all[i]->ending);
        if (length > ending && strcasecmp(path + length - ending, all[i]->ending) == 0) {
            return all[i];
        }
    }
    return NULL;
}

stp_result scan_file_open(stp_context* context, const scan_file_desc* desc, scan_file* file)
{
    *file = (scan_file){.context = context,
                        .format = scan_format_of(desc->path),
                        .desc = *desc,
                        .bounds = stp_boxd_empty(),
                        .stored = stp_boxd_empty()};
    if (file->format == NULL) {
        return stp_fail(context, STP_ERROR_ARGUMENT, "%s: expected .las, .ptx, .ply or .e57",
                        desc->path);
    }
    stp_result result = stp_file_writer_open(context, desc->path, &file->writer);
    if (result == STP_OK) {
        result = file->format->begin != NULL ? file->format->begin(file) : STP_OK;
        if (result != STP_OK) {
            scan_file_abort(file);
        }
    }
    return result;
}

stp_result scan_file_begin_station(scan_file* file, const scan_station* station)
{
    return file->format->begin_station != NULL ? file->format->begin_station(file, station)
                                               : STP_OK;
}

stp_result scan_file_add(scan_file* file, const scan_station* station, const scan_point* points,
                         size_t count)
{
    assert(file->writer != NULL && "the file is open");
    for (size_t i = 0; i < count; ++i) {
        const scan_point* p = &points[i];
        file->points += p->hit ? 1 : 0;
        file->misses += p->hit ? 0 : 1;
        if (p->hit) {
            stp_boxd_add(&file->bounds, (stp_vec3d){p->place[0], p->place[1], p->place[2]});
        }
    }
    return file->format->add(file, station, points, count);
}

stp_result scan_file_end_station(scan_file* file, const scan_station* station)
{
    return file->format->end_station != NULL ? file->format->end_station(file, station) : STP_OK;
}

static void release(scan_file* file)
{
    stp_free(file->context, file->state);
    file->state = NULL;
    file->writer = NULL;
}

stp_result scan_file_close(scan_file* file)
{
    assert(file->writer != NULL && "closed or aborted once");
    stp_result result = file->format->end != NULL ? file->format->end(file) : STP_OK;
    if (result != STP_OK) {
        scan_file_abort(file);
        return result;
    }
    result = stp_file_writer_commit(file->writer);
    release(file);
    return result;
}

void scan_file_abort(scan_file* file)
{
    assert(file->writer != NULL && "closed or aborted once");
    stp_file_writer_abort(file->writer);
    release(file);
}
