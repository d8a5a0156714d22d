// SPDX-License-Identifier: MIT
#include "draw/gl/gl_program.h"

#include "shaders_embedded.h"

#include "base/core/context.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { INCLUDES_MAX = 16, MAX_PATH_BYTES = 4096, LOG_MAX = 2048, MAX_FILE = 1 << 20 };

static const char version[] = "#version 450 core\n";

typedef struct text_maker {
    stp_context* context;
    char* text;
    size_t size, capacity;
    const char* included[INCLUDES_MAX]; ///< names in the embedded table
    size_t included_count;
    bool failed;
} text_maker;

static void add(text_maker* maker, const char* from, size_t size)
{
    if (maker->failed) {
        return;
    }
    if (maker->size + size + 1 > maker->capacity) {
        if (!STP_MAKE_ROOM(maker->context, maker->text, maker->capacity, maker->size + size + 1)) {
            maker->failed = true;
            (void)stp_fail_memory(maker->context);
            return;
        }
    }
    assert(maker->size + size < maker->capacity && "a final zero fits");
    memcpy(maker->text + maker->size, from, size);
    maker->size += size;
    maker->text[maker->size] = 0;
}

static size_t find_shader(const char* name, size_t length)
{
    size_t count = sizeof(shaders) / sizeof(shaders[0]);
    for (size_t i = 0; i < count; ++i) {
        if (strlen(shaders[i].name) == length && memcmp(shaders[i].name, name, length) == 0) {
            return i;
        }
    }
    return count;
}

/// A shader file in the folder named by the environment; NULL if there is none.
static char* read_override(stp_context* context, const char* name)
{
    const char* folder = getenv("STP_SHADER_DIR");
    char path[MAX_PATH_BYTES];
    if (folder == NULL || snprintf(path, sizeof(path), "%s/%s", folder, name) >= MAX_PATH_BYTES) {
        return NULL;
    }
    FILE* file = fopen(path, "rb");
    char* text = file != NULL ? stp_alloc(context, MAX_FILE) : NULL;
    if (text != NULL) {
        text[fread(text, 1, MAX_FILE - 1, file)] = 0;
    }
    if (file != NULL) {
        fclose(file);
    }
    return text;
}

static void add_file(text_maker* maker, const char* name, size_t length);

static void add_lines(text_maker* maker, const char* text)
{
    static const char include[] = "#include \"";
    while (*text != 0 && !maker->failed) {
        size_t size = strcspn(text, "\n");
        size += text[size] == '\n';
        if (strncmp(text, include, sizeof(include) - 1) == 0) {
            const char* name = text + sizeof(include) - 1;
            add_file(maker, name, strcspn(name, "\"\n"));
        } else {
            add(maker, text, size);
        }
        text += size;
    }
}

static void add_file(text_maker* maker, const char* name, size_t length)
{
    size_t found = find_shader(name, length);
    if (found == sizeof(shaders) / sizeof(shaders[0])) {
        maker->failed = true;
        (void)stp_fail(maker->context, STP_ERROR_UNSUPPORTED, "gl: unknown shader %.*s",
                       (int)length, name);
        return;
    }
    for (size_t i = 0; i < maker->included_count; ++i) {
        if (maker->included[i] == shaders[found].name) {
            return;
        }
    }
    if (maker->included_count < INCLUDES_MAX) {
        maker->included[maker->included_count++] = shaders[found].name;
    }
    char* text = read_override(maker->context, shaders[found].name);
    add_lines(maker, text != NULL ? text : (const char*)shaders[found].text);
    stp_free(maker->context, text);
}

char* stp_gl_program_text(stp_context* context, const char* name, const char* defines)
{
    text_maker maker = {.context = context};
    add(&maker, version, sizeof(version) - 1);
    if (defines != NULL) {
        add(&maker, defines, strlen(defines));
    }
    add_file(&maker, name, strlen(name));
    if (maker.failed) {
        stp_free(context, maker.text);
        return NULL;
    }
    return maker.text;
}

/// The driver's first line.
static int first_line(const char* text)
{
    return (int)strcspn(text, "\n");
}

static stp_result compile(stp_context* context, const stp_gl* gl, GLenum stage, const char* name,
                          const char* defines, GLuint program)
{
    char* text = stp_gl_program_text(context, name, defines);
    if (text == NULL) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    GLuint shader = gl->CreateShader(stage);
    const char* source = text;
    GLint compiled = 0;
    gl->ShaderSource(shader, 1, &source, NULL);
    gl->CompileShader(shader);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    stp_result result = STP_OK;
    if (!compiled) {
        char log[LOG_MAX] = "";
        gl->GetShaderInfoLog(shader, sizeof(log), NULL, log);
        result =
            stp_fail(context, STP_ERROR_UNSUPPORTED, "gl: %s: %.*s", name, first_line(log), log);
    } else {
        gl->AttachShader(program, shader);
    }
    gl->DeleteShader(shader); // deleted together with the program
    stp_free(context, text);
    return result;
}

static stp_result link_program(stp_context* context, const stp_gl* gl, const char* name,
                               GLuint program)
{
    GLint linked = 0;
    gl->LinkProgram(program);
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    gl->ObjectLabel(GL_PROGRAM, program, -1, name);
    if (!linked) {
        char log[LOG_MAX] = "";
        gl->GetProgramInfoLog(program, sizeof(log), NULL, log);
        return stp_fail(context, STP_ERROR_UNSUPPORTED, "gl: %s: %.*s", name, first_line(log), log);
    }
    return STP_OK;
}

static stp_result create(stp_context* context, const stp_gl* gl, const char* const names[],
                         const GLenum stages[], int count, const char* defines, GLuint* program)
{
    GLuint made = gl->CreateProgram();
    stp_result result = STP_OK;
    *program = 0;
    for (int i = 0; i < count && result == STP_OK; ++i) {
        result = compile(context, gl, stages[i], names[i], defines, made);
    }
    if (result == STP_OK) {
        result = link_program(context, gl, names[count - 1], made);
    }
    if (result != STP_OK) {
        gl->DeleteProgram(made);
        return result;
    }
    *program = made;
    return STP_OK;
}

stp_result stp_gl_program_create(stp_context* context, const stp_gl* gl, const char* vertex,
                                 const char* fragment, const char* defines, GLuint* program)
{
    const char* const names[] = {vertex, fragment};
    const GLenum stages[] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER};
    return create(context, gl, names, stages, 2, defines, program);
}

stp_result stp_gl_program_create_compute(stp_context* context, const stp_gl* gl,
                                         const char* compute, const char* defines, GLuint* program)
{
    const GLenum stages[] = {GL_COMPUTE_SHADER};
    return create(context, gl, &compute, stages, 1, defines, program);
}
