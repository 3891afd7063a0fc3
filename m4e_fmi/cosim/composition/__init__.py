"""A whole system as one program: its equations connected, without steps between them."""
