// SPDX-License-Identifier: MIT
#include "program/present/canvas.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

stp_result svg_check(stp_context* context, const char* path)
{
    stp_file_writer* writer = NULL;
    stp_result result = stp_file_writer_open(context, path, &writer);
    stp_file_writer_abort(writer);
    return result;
}

stp_result svg_open(stp_context* context, const char* path, double width, double height, svg* s)
{
    *s = (svg){0};
    stp_result result = stp_file_writer_open(context, path, &s->writer);
    if (result == STP_OK) {
        svg_put(s,
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
                "font-family=\"sans-serif\" "
                "font-size=\"12\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n",
                width, height);
    }
    return result;
}

void svg_put(svg* s, const char* format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    int size = vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    if (s->result == STP_OK && size > 0) {
        size_t length = (size_t)size < sizeof(text) ? (size_t)size : sizeof(text) - 1;
        s->result = stp_file_writer_append(s->writer, text, length);
    }
}

void svg_put_text(svg* s, const char* text)
{
    for (; *text != 0; ++text) {
        if (strchr("<>&\"'", *text) != NULL || (unsigned char)*text < ' ') {
            svg_put(s, "&#%d;", (unsigned char)*text < ' ' ? ' ' : *text);
        } else {
            svg_put(s, "%c", *text);
        }
    }
}

stp_result svg_close(svg* s)
{
    svg_put(s, "</svg>\n");
    if (s->result != STP_OK) {
        stp_file_writer_abort(s->writer);
        return s->result;
    }
    return stp_file_writer_commit(s->writer);
}
