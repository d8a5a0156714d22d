// SPDX-License-Identifier: MIT
#include "base/io/file.h"
#include "program/present/flight.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static json_t* vector(stp_vec3d p)
{
    return json_pack("[f, f, f]", p.x, p.y, p.z);
}

static json_t* describe(const stp_flight* flight)
{
    json_t* keys = json_array();
    bool whole = keys != NULL;
    for (size_t i = 0; whole && i < flight->key_count; ++i) {
        const stp_flight_key* key = &flight->keys[i];
        json_t* object = json_pack("{s:f, s:o, s:o, s:o}", "t", key->t, "eye", vector(key->eye),
                                   "target", vector(key->target), "up", vector(key->up));
        whole = json_array_append_new(keys, object) == 0;
    }
    if (!whole) {
        json_decref(keys);
        return NULL;
    }
    return json_pack("{s:f, s:f, s:o}", "fov", flight->fov_degrees, "fps", flight->fps, "keys",
                     keys);
}

stp_result stp_flight_write(stp_context* context, const char* path, const stp_flight* flight)
{
    json_t* root = describe(flight);
    char* text = root != NULL ? json_dumps(root, JSON_INDENT(1) | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    if (text == NULL) {
        return stp_fail_memory(context);
    }
    stp_file_writer* writer;
    stp_result result = stp_file_writer_open(context, path, &writer);
    if (result == STP_OK) {
        result = stp_file_writer_append(writer, text, strlen(text));
        if (result == STP_OK) {
            result = stp_file_writer_commit(writer);
        } else {
            stp_file_writer_abort(writer);
        }
    }
    free(text);
    return result;
}
