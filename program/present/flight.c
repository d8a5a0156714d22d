// SPDX-License-Identifier: MIT
//
// Interpolates between two keys with a cubic Hermite curve. The slope at a key is that of the
// parabola through the key and its two neighbours, (h2 d1 + h1 d2) / (h1 + h2), with d the slopes
// of the two spans and h their lengths in time. This is the Catmull-Rom spline for unevenly spaced
// knots (Barry and Goldman 1988), and (p2 - p0) / 2 for even ones. At the ends it is the span's own
// slope, as if the curve were mirrored there.
#include "program/present/flight.h"

#include "base/io/file.h"
#include "base/math/math.h"
#include "program/present/viewpoints_internal.h"

#include <assert.h>
#include <string.h>

static const double max_coordinate = 1e12; // prevents overflow
static const double min_span = 1e-6;       // seconds between keys

typedef struct reader {
    stp_context* context;
    const char* name;
    size_t key; ///< index of the current key
} reader;

static stp_result fail_key(const reader* r, const char* member, const char* expected)
{
    return stp_fail(r->context, STP_ERROR_FORMAT, "%s: key %zu: \"%s\" must be %s", r->name, r->key,
                    member, expected);
}

// Reads a number of the whole flight, or `missing` if absent.
static stp_result read_setting(const reader* r, const json_t* root, const char* member, double low,
                               double high, double missing, double* value)
{
    const json_t* json = json_object_get(root, member);
    *value = json != NULL ? json_number_value(json) : missing;
    if ((json != NULL && !json_is_number(json)) || !(*value >= low && *value <= high)) {
        return stp_fail(r->context, STP_ERROR_FORMAT,
                        "%s: \"%s\" must be a number from %.15g to %.15g", r->name, member, low,
                        high);
    }
    return STP_OK;
}

static stp_result read_vector(const reader* r, const json_t* key, const char* member,
                              stp_vec3d* vector)
{
    double values[3] = {0};
    bool good = stp_json_numbers(json_object_get(key, member), 3, max_coordinate, values);
    *vector = (stp_vec3d){values[0], values[1], values[2]};
    return good ? STP_OK : fail_key(r, member, "three numbers of at most 1e12 in size");
}

static stp_result read_key(const reader* r, const json_t* json, stp_flight_key* key)
{
    const json_t* time = json_object_get(json, "t");
    key->t = json_number_value(time);
    if (!json_is_number(time) || fabs(key->t) > max_coordinate) {
        return fail_key(r, "t", "a number of seconds");
    }
    stp_result result = read_vector(r, json, "eye", &key->eye);
    if (result == STP_OK) {
        result = read_vector(r, json, "target", &key->target);
    }
    key->up = (stp_vec3d){0, 1, 0};
    if (result == STP_OK && json_object_get(json, "up") != NULL) {
        result = read_vector(r, json, "up", &key->up);
        if (result == STP_OK && !(stp_lengthd(key->up) > 1e-12)) {
            return fail_key(r, "up", "a vector longer than 0");
        }
    }
    if (result == STP_OK && !(stp_lengthd(stp_subd(key->target, key->eye)) > 1e-12)) {
        return fail_key(r, "target", "different from \"eye\"");
    }
    key->up = stp_normalized(key->up);
    return result;
}

static stp_result read_keys(reader* r, const json_t* list, stp_flight* flight)
{
    size_t count = json_array_size(list);
    if (!json_is_array(list) || count == 0) {
        return stp_fail(r->context, STP_ERROR_FORMAT,
                        "%s: \"keys\" must be an array of at least one key", r->name);
    }
    flight->keys = STP_NEW_ARRAY(r->context, stp_flight_key, count);
    if (flight->keys == NULL) {
        return stp_fail_memory(r->context);
    }
    for (; r->key < count; ++r->key) {
        stp_flight_key* key = &flight->keys[r->key];
        stp_result result = read_key(r, json_array_get(list, r->key), key);
        if (result != STP_OK) {
            return result;
        }
        if (r->key > 0 && !(key->t - key[-1].t >= min_span)) {
            return fail_key(r, "t", "greater than that of the previous key");
        }
    }
    flight->key_count = count;
    if (flight->keys[count - 1].t - flight->keys[0].t > STP_FLIGHT_SECONDS_MAX) {
        return stp_fail(r->context, STP_ERROR_FORMAT,
                        "%s: the flight is longer than a day (%.0f s)", r->name,
                        STP_FLIGHT_SECONDS_MAX);
    }
    return STP_OK;
}

static stp_result read_flight(reader* r, const json_t* root, stp_flight* flight)
{
    if (!json_is_object(root)) {
        return stp_fail(r->context, STP_ERROR_FORMAT, "%s: a flight is one JSON object", r->name);
    }
    stp_result result = read_setting(r, root, "fov", STP_FOV_DEGREES_MIN, STP_FOV_DEGREES_MAX, 60.0,
                                     &flight->fov_degrees);
    if (result == STP_OK) {
        result = read_setting(r, root, "fps", 0.01, 1000.0, 60.0, &flight->fps);
    }
    return result == STP_OK ? read_keys(r, json_object_get(root, "keys"), flight) : result;
}

stp_result stp_flight_parse(stp_context* context, const char* name, const unsigned char* bytes,
                            size_t size, stp_flight* flight)
{
    *flight = (stp_flight){0};
    stp_json_text text = {name, "a flight", bytes, size, STP_FLIGHT_BYTES_MAX};
    json_t* root;
    stp_result result = stp_json_parse(context, &text, &root);
    if (result != STP_OK) {
        return result;
    }
    reader r = {.context = context, .name = name};
    result = read_flight(&r, root, flight);
    stp_json_release(context, &text, root);
    if (result != STP_OK) {
        stp_flight_destroy(context, flight);
    }
    return result;
}

stp_result stp_flight_read(stp_context* context, const char* path, stp_flight* flight)
{
    *flight = (stp_flight){0};
    stp_mapped_file file;
    stp_result result = stp_file_map(context, path, &file);
    if (result == STP_OK) {
        result = stp_flight_parse(context, path, file.bytes, file.size, flight);
        stp_file_unmap(&file);
    }
    return result;
}

void stp_flight_destroy(stp_context* context, stp_flight* flight)
{
    stp_free(context, flight->keys);
    *flight = (stp_flight){0};
}

uint32_t stp_flight_frame_count(const stp_flight* flight, double fps)
{
    assert(flight->key_count > 0 && "a flight that was read has a key");
    double seconds = flight->keys[flight->key_count - 1].t - flight->keys[0].t;
    return 1 + (uint32_t)(seconds * fps + 1e-6); // 2 s are 121 frames, however they round
}

// The last key at or before t, but never the last of all.
static size_t find_span(const stp_flight* flight, double t)
{
    size_t low = 0, high = flight->key_count - 1; // keys[low].t <= t < keys[high].t
    assert(low < high && flight->keys[low].t <= t && t < flight->keys[high].t);
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        *(flight->keys[middle].t <= t ? &low : &high) = middle;
    }
    assert(flight->keys[low].t <= t && t < flight->keys[low + 1].t && "keys ascend");
    return low;
}

// p: the points of the span's two keys and their neighbours; h: the times between them, 0 if a
// neighbour is missing.
static stp_vec3d interpolate(const stp_vec3d p[4], const double h[3], double u)
{
    assert(h[0] >= 0.0 && h[1] > 0.0 && h[2] >= 0.0 && "keys ascend");
    assert(u >= 0.0 && u <= 1.0);
    stp_vec3d slope = stp_scaled(stp_subd(p[2], p[1]), 1.0 / h[1]);
    stp_vec3d start = slope, end = slope;
    if (h[0] > 0.0) {
        stp_vec3d before = stp_scaled(stp_subd(p[1], p[0]), 1.0 / h[0]);
        start = stp_scaled(stp_addd(stp_scaled(before, h[1]), stp_scaled(slope, h[0])),
                           1.0 / (h[0] + h[1]));
    }
    if (h[2] > 0.0) {
        stp_vec3d after = stp_scaled(stp_subd(p[3], p[2]), 1.0 / h[2]);
        end = stp_scaled(stp_addd(stp_scaled(slope, h[2]), stp_scaled(after, h[1])),
                         1.0 / (h[1] + h[2]));
    }
    double v = 1.0 - u;
    stp_vec3d places = stp_addd(stp_scaled(p[1], v * v * (1.0 + 2.0 * u)),
                                stp_scaled(p[2], u * u * (3.0 - 2.0 * u)));
    stp_vec3d slopes = stp_subd(stp_scaled(start, u * v * v), stp_scaled(end, u * u * v));
    return stp_addd(places, stp_scaled(slopes, h[1]));
}

static void set_key_view(const stp_flight_key* key, stp_view* view)
{
    view->eye = key->eye;
    view->target = key->target;
    view->up = key->up;
}

void stp_flight_get_view(const stp_flight* flight, double t, stp_view* view)
{
    const stp_flight_key* first = flight->keys;
    const stp_flight_key* last = flight->keys + flight->key_count - 1;
    view->fov_degrees = flight->fov_degrees;
    view->ortho_height = 0.0;
    if (!(t > first->t) || t >= last->t) {
        set_key_view(t >= last->t ? last : first, view);
        return;
    }
    size_t span = find_span(flight, t);
    const stp_flight_key* k = &flight->keys[span];
    const stp_flight_key* before = span > 0 ? k - 1 : k;
    const stp_flight_key* after = k + 1 < last ? k + 2 : k + 1;
    const double h[3] = {k->t - before->t, k[1].t - k->t, after->t - k[1].t};
    double u = (t - k->t) / h[1];
    const stp_vec3d eyes[4] = {before->eye, k->eye, k[1].eye, after->eye};
    const stp_vec3d targets[4] = {before->target, k->target, k[1].target, after->target};
    view->eye = interpolate(eyes, h, u);
    view->target = interpolate(targets, h, u);
    stp_vec3d up = stp_addd(stp_scaled(k->up, 1.0 - u), stp_scaled(k[1].up, u));
    // the mix of opposite vectors has no direction
    view->up = stp_lengthd(up) > 1e-6 ? stp_normalized(up) : u < 0.5 ? k->up : k[1].up;
}
