"""The boundary walk and a trial: fitted, forecasting, compared."""
