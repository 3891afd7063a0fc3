"""What commands share: options and their values, printing, and the report of a defect."""
