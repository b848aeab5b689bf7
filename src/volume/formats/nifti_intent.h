/* The intent code of NIfTI files. */
#ifndef CVOL_VOLUME_FORMATS_NIFTI_INTENT_H
#define CVOL_VOLUME_FORMATS_NIFTI_INTENT_H

/* 1 for a NIfTI file with the intent code of labels, 1002. */
int cvol_nifti_has_label_intent(const char *path);

#endif
