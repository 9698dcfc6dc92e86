/* The symbols that a shared library of dvdx shows; everything else in it is hidden. Readable by C. */
#ifndef DVDX_EXPORT_H
#define DVDX_EXPORT_H

#define DVDX_EXPORT __attribute__((visibility("default")))

#endif
