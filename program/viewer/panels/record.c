// SPDX-License-Identifier: MIT
// Recording and playing flights, and the output folder of the viewer.
#include "base/core/clock.h"
#include "program/options/program.h"
#include "program/viewer/panels/panels.h"

#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const double key_ms = 200.0;

void record_name_file(const viewer* v, const char* ending, char* path, size_t size)
{
    char folder[PATH_ROOM];
    const char* pictures = getenv("XDG_PICTURES_DIR");
    const char* home = getenv("HOME");
    if (pictures != NULL && pictures[0] == '/') {
        snprintf(folder, sizeof(folder), "%s/Stipple", pictures);
    } else if (home != NULL && home[0] == '/') {
        snprintf(folder, sizeof(folder), "%s/Pictures", home);
        (void)mkdir(folder, 0777);
        snprintf(folder, sizeof(folder), "%s/Pictures/Stipple", home);
    } else {
        snprintf(folder, sizeof(folder), ".");
    }
    if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
        snprintf(folder, sizeof(folder), ".");
    }
    const char* name = strrchr(v->file, '/') != NULL ? strrchr(v->file, '/') + 1 : v->file;
    name = program_is_scene(name) ? strchr(name, ':') + 1 : name;
    int number = 0;
    do {
        number += 1;
        snprintf(path, size, "%s/%.*s-%03d%s", folder, (int)strcspn(name, ".,"), name, number,
                 ending);
    } while (number < 999 && access(path, F_OK) == 0);
}

static void add_key(viewer* v, double now)
{
    flight_record* r = &v->record;
    if (r->count == r->capacity) {
        size_t wanted = r->capacity > 0 ? 2 * r->capacity : 64;
        stp_flight_key* keys = realloc(r->keys, wanted * sizeof(*keys));
        if (keys == NULL) {
            return;
        }
        r->keys = keys;
        r->capacity = wanted;
    }
    stp_view view = {0};
    assert((r->count == 0 || now >= r->last_ms) && "keys are in order of time");
    stp_navigator_write_view(&v->camera, &view);
    r->last_ms = now;
    r->keys[r->count++] = (stp_flight_key){
        .t = 1e-3 * (now - r->start_ms), .eye = view.eye, .target = view.target, .up = view.up};
}

static void write_record(viewer* v)
{
    char path[PATH_ROOM + 512];
    const flight_record* r = &v->record;
    stp_flight flight = {
        .fov_degrees = v->camera.fov_degrees, .fps = 60.0, .keys = r->keys, .key_count = r->count};
    record_name_file(v, ".flight.json", path, sizeof(path));
    if (stp_flight_write(v->context, path, &flight) == STP_OK) {
        viewer_show_message(v, false, "Flight of %.1f s: %s", r->keys[r->count - 1].t, path);
    }
}

void record_switch(viewer* v)
{
    flight_record* r = &v->record;
    double now = stp_clock_ms();
    if (v->scene == NULL) {
        return;
    }
    r->on = !r->on;
    r->plays = false;
    if (r->on) {
        r->count = 0;
        r->start_ms = now;
        add_key(v, now);
        viewer_show_message(v, false, "Recording; R ends it");
    } else {
        if (now - r->last_ms > 1.0) {
            add_key(v, now);
        }
        if (r->count > 1) {
            write_record(v);
        } else {
            viewer_show_message(v, false, "The recording was too short to keep");
        }
    }
}

void record_play(viewer* v)
{
    flight_record* r = &v->record;
    r->plays = !r->plays && r->count > 1;
    r->start_ms = stp_clock_ms();
}

void record_step(viewer* v)
{
    flight_record* r = &v->record;
    double now = stp_clock_ms();
    if (r->on && now - r->last_ms >= key_ms) {
        add_key(v, now);
    } else if (r->plays) {
        double t = 1e-3 * (now - r->start_ms);
        assert(r->count > 1 && "record_play needs two keys");
        stp_flight flight = {.fov_degrees = v->camera.fov_degrees,
                             .fps = 60.0,
                             .keys = r->keys,
                             .key_count = r->count};
        stp_view view = {0};
        stp_flight_get_view(&flight, t, &view);
        stp_navigator_read_view(&v->camera, &view);
        if (t >= r->keys[r->count - 1].t) {
            r->plays = false;
            viewer_redraw(v);
        }
    }
}

void record_end(viewer* v)
{
    if (v->record.on) {
        record_switch(v);
    }
    free(v->record.keys);
    v->record = (flight_record){0};
}
