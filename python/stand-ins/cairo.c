/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stands for cairo in the wheel. Cairo would bring 17 libraries of X11 and of fonts, for nothing
 * but the labelled pictures of compare, lightfield and measure --grid. Here no page can be made;
 * mcv_page_new (host/io/figure.c) says why, and nothing is drawn on a page that is not there.
 * cairo_status_t is an int whose 0 is success.
 */
#define NOTHING(name) \
    void *name(void); \
    void *name(void) { return 0; }

NOTHING(cairo_create)
NOTHING(cairo_destroy)
NOTHING(cairo_fill)
NOTHING(cairo_font_extents)
NOTHING(cairo_get_target)
NOTHING(cairo_image_surface_create)
NOTHING(cairo_image_surface_get_data)
NOTHING(cairo_image_surface_get_stride)
NOTHING(cairo_line_to)
NOTHING(cairo_move_to)
NOTHING(cairo_new_path)
NOTHING(cairo_paint)
NOTHING(cairo_rectangle)
NOTHING(cairo_rel_line_to)
NOTHING(cairo_restore)
NOTHING(cairo_rotate)
NOTHING(cairo_save)
NOTHING(cairo_select_font_face)
NOTHING(cairo_set_font_size)
NOTHING(cairo_set_line_width)
NOTHING(cairo_set_source_rgb)
NOTHING(cairo_set_source_rgba)
NOTHING(cairo_set_source_surface)
NOTHING(cairo_show_text)
NOTHING(cairo_stroke)
NOTHING(cairo_surface_destroy)
NOTHING(cairo_surface_flush)
NOTHING(cairo_surface_mark_dirty)
NOTHING(cairo_surface_write_to_png_stream)
NOTHING(cairo_text_extents)
NOTHING(cairo_translate)

int cairo_status(void);
int cairo_status(void) { return 1; }

const char *cairo_status_to_string(void);
const char *cairo_status_to_string(void) {
    return "this package draws no labels; a program built from the sources does";
}
