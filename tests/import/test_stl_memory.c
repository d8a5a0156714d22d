// SPDX-License-Identifier: MIT
// A large STL file is read in place: memory holds only the mesh, and a table that is small
// in comparison.
#include "formats_test.h"

#include "base/io/bytes.h"

enum { SIDE = 150, FACETS = 2 * SIDE * SIDE };

// The corners of a sheet of SIDE x SIDE squares.
static void corner_of(int facet, int corner, float p[3])
{
    static const int steps[6][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 0}, {0, 1}, {1, 1}};
    const int* step = steps[facet % 2 * 3 + corner];
    int x = facet / 2 % SIDE + step[0], y = facet / 2 / SIDE + step[1];
    p[0] = (float)x;
    p[1] = (float)(x * y % 7) * 0.25f;
    p[2] = (float)y;
}

static unsigned char* make_binary(size_t* size)
{
    *size = 84 + (size_t)FACETS * 50;
    unsigned char* bytes = calloc(1, *size);
    if (bytes != NULL) {
        stp_write_u32(bytes + 80, FACETS);
        for (int i = 0; i < 3 * FACETS; ++i) {
            float p[3];
            corner_of(i / 3, i % 3, p);
            for (size_t k = 0; k < 3; ++k) {
                stp_write_f32(bytes + 84 + (size_t)(i / 3) * 50 + 12 + 12 * (size_t)(i % 3) + 4 * k,
                              p[k]);
            }
        }
    }
    return bytes;
}

// The last line has no line end.
static unsigned char* make_ascii(size_t* size)
{
    size_t room = (size_t)FACETS * 200 + 100, at = 0;
    char* text = malloc(room);
    if (text == NULL) {
        return NULL;
    }
    at += (size_t)snprintf(text, room, "solid\n");
    for (int f = 0; f < FACETS; ++f) {
        at += (size_t)snprintf(text + at, room - at, "facet normal 0 0 0\nouter loop\n");
        for (int c = 0; c < 3; ++c) {
            float p[3];
            corner_of(f, c, p);
            at += (size_t)snprintf(text + at, room - at, "vertex %.4f %.4f %.4f\n", (double)p[0],
                                   (double)p[1], (double)p[2]);
        }
        at += (size_t)snprintf(text + at, room - at, "endloop\nendfacet%s",
                               f + 1 < FACETS ? "\n" : "");
    }
    *size = at;
    return (unsigned char*)text;
}

static int is_sheet(const stp_mesh* mesh)
{
    int good = mesh->vertex_count == (SIDE + 1) * (SIDE + 1) && mesh->triangle_count == FACETS;
    uint32_t next = 0; // vertices are numbered in order of appearance
    for (int i = 0; i < 3 * FACETS && good; ++i) {
        float wanted[3];
        corner_of(i / 3, i % 3, wanted);
        uint32_t index = mesh->indices[i];
        good = index <= next &&
               memcmp(mesh->positions + 3 * (size_t)index, wanted, sizeof(wanted)) == 0;
        next += index == next;
    }
    return good;
}

void test_stl_takes_little_memory(test_state* test)
{
    for (int text = 0; text < 2; ++text) {
        size_t size = 0;
        unsigned char* bytes = text ? make_ascii(&size) : make_binary(&size);
        CHECK(bytes != NULL);
        stp_context* context = test_context(NULL, 1, NULL);
        stp_result result;
        stp_scene* scene = import_bytes(context, "sheet.stl", bytes, size, &result);
        CHECK_EQUAL(STP_OK, result);
        CHECK(is_sheet(&scene->meshes[0]));
        // the mesh takes 18 bytes a triangle, the file 50 or more
        size_t peak = stp_context_peak_bytes(context);
        if (4 * peak > 3 * size) {
            fprintf(stderr, "%zu bytes for a file of %zu\n", peak, size);
        }
        CHECK(4 * peak < 3 * size);
        stp_scene_destroy(scene);
        stp_context_destroy(context);
        free(bytes);
    }
}
