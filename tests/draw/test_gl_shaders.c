// SPDX-License-Identifier: MIT
// Shaders that need features which the driver may lack are at least compiled by glslangValidator,
// if installed.
#include "tests.h"

#include "draw/gl/gl_program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct checked_shader {
    const char *name, *defines;
} checked_shader;

#define PAGES(count) "#define PAGE_COUNT " #count "\n#define PAGE_SHIFT 28\n"

/// @return the compiler's status, 0 without errors
static int compile(stp_context* context, const checked_shader* shader)
{
    const char* folder = getenv("TMPDIR");
    char path[512], command[1200];
    const char* stage = strstr(shader->name, ".comp.") != NULL   ? "comp"
                        : strstr(shader->name, ".vert.") != NULL ? "vert"
                                                                 : "frag";
    char* text;
    if (stp_gl_program_text(context, shader->name, shader->defines, &text) != STP_OK) {
        return -1;
    }
    snprintf(path, sizeof(path), "%s/stipple_%d.%s", folder != NULL ? folder : "/tmp",
             (int)getpid(), stage);
    FILE* file = fopen(path, "w");
    bool written = file != NULL && fputs(text, file) >= 0;
    written = file != NULL && fclose(file) == 0 && written;
    stp_free(context, text);
    snprintf(command, sizeof(command), "glslangValidator -S %s %s > /dev/null", stage, path);
    int status = written ? system(command) : -1;
    unlink(path);
    return status;
}

void test_gl_shaders_that_are_unknown(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    char* text;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, stp_gl_program_text(context, "no.frag.glsl", NULL, &text));
    CHECK(text == NULL && log.errors == 1);
    stp_context_destroy(context);
}

void test_gl_shaders_are_glsl(test_state* test)
{
    static const checked_shader shaders[] = {
        {"raster.comp.glsl", PAGES(1)},
        {"raster.comp.glsl", PAGES(8)},
        {"merge.frag.glsl", ""},
        {"splat.vert.glsl", PAGES(2)},
        {"splat.frag.glsl", PAGES(2)},
        {"large.vert.glsl", PAGES(2)},
        {"large.frag.glsl", PAGES(2)},
        {"triangle.vert.glsl", PAGES(2)},
        {"triangle.frag.glsl", "#define KEEP\n" PAGES(2)},
        {"shade.comp.glsl", PAGES(2)},
        {"screen.vert.glsl", ""},
        {"planes.comp.glsl", PAGES(2)},
        {"blend.vert.glsl", PAGES(2)},
        {"blend.vert.glsl", "#define LEAVES\n" PAGES(2)},
        {"blend.frag.glsl", PAGES(2)},
        {"tolerant.frag.glsl", PAGES(2)},
        {"tolerant.frag.glsl", "#define INTERLOCK\n" PAGES(2)},
        {"tolerant_merge.frag.glsl", ""},
    };
    if (system("glslangValidator --version > /dev/null 2>&1") != 0) {
        SKIP("there is no glslangValidator (package glslang-tools)");
    }
    stp_context* context = test_context(NULL, 1, NULL);
    for (size_t i = 0; i < sizeof(shaders) / sizeof(shaders[0]); ++i) {
        int status = compile(context, &shaders[i]);
        if (status != 0) {
            printf("%s %s\n", shaders[i].name, shaders[i].defines);
        }
        CHECK_EQUAL(0, status);
    }
    // it does detect errors
    const checked_shader wrong = {"raster.comp.glsl",
                                  "#define PAGE_COUNT 1\n#define store store ?\n"};
    CHECK(compile(context, &wrong) != 0);
    stp_context_destroy(context);
}
